#pragma once
/// Adapters between a surface and the materials that scatter light there: at each hit an adapter chooses one of them,
/// or turns the normal. Members named after materials are rows of Scene::materials, each before the adapter's own row.
/// docs/conventions.md, "Adapters".

#include <cstdint>
#include <type_traits>
#include <variant>

#include "scene/texture.h"

namespace etendue {

/// `front` on the side of the shading normal; behind it `back`, as if that were the front. Neither may transmit light.
struct TwoSidedAdapter {
  std::uint32_t front = 0;
  std::uint32_t back = 0;
};
/// `inner` with the probability `opacity`, in [0,1]; otherwise light passes unchanged.
struct MaskAdapter {
  ScalarParameter opacity{0.5};
  std::uint32_t inner = 0;
};
/// `second` with the probability `weight`, in [0,1]; otherwise `first`.
struct BlendAdapter {
  ScalarParameter weight{0.5};
  std::uint32_t first = 0;
  std::uint32_t second = 0;
};

/// The treatment of turned normals.
struct TurnedNormals {
  bool mirrored = true;  ///< those facing away are mirrored; otherwise nothing is reflected there
  bool shadowed = true;  ///< they shadow like microfacets as steep as they are

  bool operator==(const TurnedNormals&) const = default;
};

/// `inner` with another shading normal: 2 c − 1 for the colour c of a texture, along dp/du, across it, and along the
/// normal. With `vertex_tangents` along the tangents of the mesh's vertices, and across those on their side.
struct NormalMapAdapter {
  ColorParameter normals{glm::dvec3(1.0)};
  std::uint32_t inner = 0;
  bool vertex_tangents = false;
  TurnedNormals turned{};
};
/// `inner` with the shading normal of a surface displaced by `height`, a picture times a number, in scene units.
struct BumpMapAdapter {
  ScalarParameter height{1.0};
  std::uint32_t inner = 0;
  TurnedNormals turned{};
};

using Adapter = std::variant<TwoSidedAdapter, MaskAdapter, BlendAdapter, NormalMapAdapter, BumpMapAdapter>;

/// Calls f(row) for each row that the adapter may choose.
template <typename F>
void each_choice(const Adapter& adapter, F&& f) {
  std::visit(
      [&](const auto& a) {
        using T = std::remove_cvref_t<decltype(a)>;
        if constexpr (std::is_same_v<T, TwoSidedAdapter>) {
          f(a.front);
          f(a.back);
        } else if constexpr (std::is_same_v<T, BlendAdapter>) {
          f(a.first);
          f(a.second);
        } else {
          f(a.inner);
        }
      },
      adapter);
}

}  // namespace etendue
