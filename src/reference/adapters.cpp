#include "reference/adapters.h"

#include <algorithm>

#include "reference/texture.h"
#include "scene/materials.h"

namespace etendue::reference {
namespace {

/// The normal that a normal map's colour gives for `n`, which with `side` −1 is the opposite of the surface's; not
/// normalised.
std::optional<Vec3> mapped(const Scene& scene, const Surface& surface, const Vec3& color, std::uint32_t uv_set,
                           bool vertex_tangents, const Vec3& n, double side) {
  Vec3 u(0.0);
  if (vertex_tangents) {
    const glm::dvec4 tangent = vertex_tangent(scene, surface);
    u = Vec3(tangent);
    side *= tangent.w;
  } else {
    u = tangents(scene, uv_set, surface).u;
  }
  const Vec3 along = u - n * glm::dot(n, u);
  if (!(glm::length(along) > 0.0)) return std::nullopt;
  const Vec3 t = glm::normalize(along), b = side * glm::cross(n, t);
  const Vec3 c = 2.0 * color - 1.0;
  return c.x * t + c.y * b + c.z * n;
}

/// The turned normal, mirrored about `n` if it faces away from the side on which the surface is seen.
Vec3 seen(const Vec3& turned, const Vec3& n, const Vec3& d) {
  if (glm::dot(turned, d) * glm::dot(n, d) > 0.0) return turned;
  return glm::normalize(2.0 * glm::dot(n, turned) * n - turned);
}

/// A step on the way from an adapter to a material.
struct Place {
  std::uint32_t row;
  Frame frame;
  double side = 1.0;  ///< of the frame's normal, relative to that of the surface
  std::optional<Vec3> base = {};
  bool shadowed = true;
};

/// Follows the way from an adapter to a material.
struct Chooser : Place {
  const Scene& scene;
  const Surface& surface;
  const Vec3& d;
  Decider& decider;
  double share = 1.0;
  std::optional<std::uint32_t> blended = {};  ///< row of the first blend
  std::optional<Place> other = {};            ///< the branch that the first blend did not take

  // Each continues with a row, or says that the ray passes.
  bool step(const TwoSidedAdapter& adapter) {
    const bool behind = glm::dot(d, frame.normal()) > 0.0;
    if (behind) {
      frame = frame.mirrored();
      side = -side;
      if (base) *base = -*base;
    }
    row = behind ? adapter.back : adapter.front;
    return true;
  }
  bool step(const MaskAdapter& mask) {
    if (!decider.happens(row, at_point(scene, mask.opacity, surface))) return false;
    row = mask.inner;
    return true;
  }
  bool step(const BlendAdapter& blend) {
    const double weight = std::clamp(at_point(scene, blend.weight, surface), 0.0, 1.0);
    const bool second = decider.happens(row, weight);
    if (!other) {
      blended = row;
      other = *this;
      other->row = second ? blend.first : blend.second;
      share = second ? weight : 1.0 - weight;
    }
    row = second ? blend.second : blend.first;
    return true;
  }
  /// Tangent, bitangent and normal are those of the surface; seen from behind, heights have the opposite sign.
  bool step(const NormalMapAdapter& map) {
    const std::uint32_t uv_set = scene.textures[*map.normals.texture].uv_set;
    const Vec3 color = at_point(scene, map.normals, surface);
    if (const auto to = mapped(scene, surface, color, uv_set, map.vertex_tangents, frame.normal(), side))
      turn(*to, map.turned);
    row = map.inner;
    return true;
  }
  /// The normal of p + h n from its derivatives, neglecting those of n [Blinn1978].
  bool step(const BumpMapAdapter& map) {
    const Tangents by = tangents(scene, scene.textures[*map.height.texture].uv_set, surface);
    const Vec3 n = frame.normal();
    if (glm::length(by.u) > 0.0) {
      const Vec2 slope = gradient_at(scene, map.height, surface);
      const Vec3 along = by.u - n * glm::dot(n, by.u) + slope.x * n,
                 across = by.v - n * glm::dot(n, by.v) + slope.y * n;
      const Vec3 m = glm::cross(along, across);
      turn(glm::dot(m, n) < 0.0 ? -m : m, map.turned);
    }
    row = map.inner;
    return true;
  }
  void turn(const Vec3& to, const TurnedNormals& turned) {
    if (!turned.shadowed) shadowed = false;
    if (!(glm::length(to) > 0.0)) return;
    const Vec3 n = frame.normal();
    if (!base) base = n;
    const Vec3 direction = glm::normalize(to);
    frame = Frame(turned.mirrored ? seen(direction, n, d) : direction);
  }
};

/// Follows the way to its end. Nothing if the ray passes.
std::optional<ChosenMaterial> arrive(Chooser& chooser) {
  for (;;) {
    const Material& material = chooser.scene.materials[chooser.row];
    if (!material.adapter) {
      if (std::holds_alternative<NullBsdf>(material.bsdf)) return std::nullopt;
      const Frame& frame = chooser.frame;
      return ChosenMaterial{chooser.row,
                            is_aligned(material) ? frame.along(tangents(chooser.scene, 0, chooser.surface).u) : frame,
                            chooser.base, chooser.side, chooser.shadowed};
    }
    if (!std::visit([&](const auto& adapter) { return chooser.step(adapter); }, *material.adapter)) return std::nullopt;
  }
}

Chooser begin(const Scene& scene, const Surface& surface, const Vec3& d, Decider& decider) {
  return {{.row = scene.instances[surface.instance].material, .frame = Frame(surface.ns)}, scene, surface, d, decider};
}

}  // namespace

Bsdf material_at(const Scene& scene, const ChosenMaterial& chosen, const Surface& surface, const Vec3& d) {
  Bsdf bsdf = at_point(scene, scene.materials[chosen.row].bsdf, surface);
  auto* gltf = std::get_if<GltfBsdf>(&bsdf);
  if (gltf == nullptr || !gltf->coat_keeps_normal) return bsdf;
  Vec3 n = chosen.base.value_or(chosen.frame.normal());
  // Textured parameters are evaluated at the point and become constants.
  const ColorParameter& map = std::get<GltfBsdf>(scene.materials[chosen.row].bsdf).coat_normals;
  if (map.texture) {
    const std::uint32_t uv_set = scene.textures[*map.texture].uv_set;
    const auto to =
        mapped(scene, surface, gltf->coat_normals.value, uv_set, gltf->coat_vertex_tangents, n, chosen.side);
    if (to && glm::length(*to) > 0.0) n = seen(glm::normalize(*to), n, d);
  }
  gltf->met.coat_normal = chosen.frame.to_local(n);
  return bsdf;
}

std::optional<ChosenMaterial> choose_material(const Scene& scene, const Surface& surface, const Vec3& d,
                                              const SampleRandom& random, std::uint32_t k, bool shadow_ray) {
  RandomDecider decider(surface, d, random, k, shadow_ray);
  Chooser chooser = begin(scene, surface, d, decider);
  return arrive(chooser);
}

std::optional<ChosenMaterials> choose_materials(const Scene& scene, const Surface& surface, const Vec3& d,
                                                Decider& decider) {
  Chooser chooser = begin(scene, surface, d, decider);
  const std::optional<ChosenMaterial> chosen = arrive(chooser);
  if (!chosen) return std::nullopt;
  if (!chooser.other) return ChosenMaterials{*chosen};
  const double share = chooser.share;
  static_cast<Place&>(chooser) = Place(*chooser.other);
  const std::optional<std::uint32_t> blend = chooser.blended;
  return ChosenMaterials{*chosen, share, blend, arrive(chooser)};
}

std::optional<ChosenMaterials> choose_materials(const Scene& scene, const Surface& surface, const Vec3& d,
                                                const SampleRandom& random, std::uint32_t k) {
  RandomDecider decider(surface, d, random, k, false);
  return choose_materials(scene, surface, d, decider);
}

}  // namespace etendue::reference
