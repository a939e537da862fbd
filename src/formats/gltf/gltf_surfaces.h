#pragma once
/// Turns materials of a glTF asset into materials and emitters of a scene.

#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "formats/gltf/gltf_material.h"
#include "formats/gltf/gltf_textures.h"
#include "formats/gltf/primitive.h"

namespace etendue {

/// Rows in the scene's tables of materials and emitters.
struct GltfSurface {
  std::uint32_t material = 0;
  std::optional<std::uint32_t> emitter;
};

class GltfSurfaces {
 public:
  GltfSurfaces(GltfDocument& document, GltfTextures& textures, Scene& scene, Diagnostics& diagnostics)
      : document_(document), textures_(textures), scene_(scene), sink_(diagnostics) {}

  /// What a primitive must provide for materials[index], or for the default material.
  PrimitiveNeeds needs(std::optional<std::uint32_t> index, const PrimitiveContent& content, const JsonValue& where);
  /// The material for a primitive with this content; `mirrored`: for its triangles with mirrored texture coordinates.
  GltfSurface surface(std::optional<std::uint32_t> index, const PrimitiveContent& content, bool mirrored,
                      const JsonValue& where);

 private:
  struct Traits {
    std::uint32_t uv_sets = 0;
    bool colors = false, colors_have_alpha = false, mirrored = false, normals = false;
    auto operator<=>(const Traits&) const = default;
  };

  const GltfMaterial& material(std::optional<std::uint32_t> index, const JsonValue& where);
  GltfSurface make(const GltfMaterial& m, const Traits& traits);
  Bsdf bsdf_of(const GltfMaterial& m, const Traits& traits);
  void set_specular_glossiness(const GltfMaterial& m, const Traits& traits, GltfBsdf& b);
  void set_layers(const GltfMaterial& m, const Traits& traits, GltfBsdf& b);
  void set_transmission(const GltfMaterial& m, const Traits& traits, GltfBsdf& b);
  std::optional<std::uint32_t> normal_row(const MaybeTexture& info, double scale, const Traits& traits);
  std::uint32_t with_normals(const GltfMaterial& m, const Traits& traits, std::uint32_t inner);
  std::uint32_t with_opacity(const GltfMaterial& m, const Traits& traits, std::uint32_t inner);
  std::optional<std::uint32_t> emitter_of(const GltfMaterial& m, const Traits& traits);
  ColorParameter base_color(const GltfMaterial& m, const Traits& traits);
  /// Whether alpha is not the same everywhere.
  static bool alpha_varies(const GltfMaterial& m, const Traits& traits);
  void premultiply(const GltfMaterial& m, const Traits& traits, ColorParameter& radiance);
  void dim_emission(const GltfMaterial& m, const Traits& traits, ColorParameter& radiance);
  void say_what_is_left_out(const GltfMaterial& m);

  std::optional<std::uint32_t> texture(const MaybeTexture& info, const Traits& traits, ColorSpace color_space,
                                       const TextureRecipe* recipe = nullptr);
  void assign(ScalarParameter& parameter, double factor, const MaybeTexture& info, const Traits& traits,
              TextureChannel channel, const TextureRecipe* recipe = nullptr);
  void assign(ColorParameter& parameter, const glm::dvec3& factor, const MaybeTexture& info, const Traits& traits);
  std::uint32_t add(Material row, const GltfMaterial& m);
  SourcePosition position(const GltfMaterial& m) const;
  /// Reports a warning once for each material.
  void warn_once(const GltfMaterial& m, const std::string& sentence);

  GltfDocument& document_;
  GltfTextures& textures_;
  Scene& scene_;
  Diagnostics& sink_;
  std::map<std::optional<std::uint32_t>, GltfMaterial> materials_;
  std::map<std::pair<std::optional<std::uint32_t>, Traits>, GltfSurface> surfaces_;
  std::set<std::string> said_;
};

}  // namespace etendue
