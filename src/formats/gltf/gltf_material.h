#pragma once
/// A material as a glTF document describes it, with defaults filled in. How it is rendered is decided elsewhere
/// (gltf_surfaces.h).

#include <optional>
#include <string>
#include <vector>

#include "formats/gltf/gltf_document.h"

namespace etendue {

/// A reference to textures[index].
struct GltfTextureInfo {
  std::uint32_t index = 0;
  std::uint32_t uv_set = 0;
  glm::dmat3 transform{1.0};  ///< KHR_texture_transform, for coordinates with v downward
  const JsonValue* where = nullptr;
};
using MaybeTexture = std::optional<GltfTextureInfo>;

struct GltfMaterial {
  enum class Alpha { opaque, mask, blend };
  enum class Model { metallic_roughness, specular_glossiness, unlit };

  std::string name;
  const JsonValue* where = nullptr;
  Model model = Model::metallic_roughness;
  Alpha alpha = Alpha::opaque;
  double alpha_cutoff = 0.5;
  bool double_sided = false;

  glm::dvec4 base_color{1.0};  ///< for specular-glossiness the diffuse factor
  double metallic = 1.0, roughness = 1.0;
  MaybeTexture base_color_texture, metallic_roughness_texture;
  glm::dvec3 specular_factor{1.0};  ///< KHR_materials_pbrSpecularGlossiness
  double glossiness = 1.0;
  MaybeTexture specular_glossiness_texture;

  MaybeTexture normal_texture, occlusion_texture;
  double normal_scale = 1.0;
  glm::dvec3 emission{0.0};  ///< factor · strength, cd/m²
  MaybeTexture emission_texture;

  double clearcoat = 0.0, clearcoat_roughness = 0.0;
  MaybeTexture clearcoat_texture, clearcoat_roughness_texture, clearcoat_normal_texture;
  double clearcoat_normal_scale = 1.0;
  glm::dvec3 sheen_color{0.0};
  double sheen_roughness = 0.0;
  MaybeTexture sheen_color_texture, sheen_roughness_texture;
  double specular = 1.0;
  glm::dvec3 specular_color{1.0};
  MaybeTexture specular_texture, specular_color_texture;
  double ior = 1.5;
  double transmission = 0.0;
  MaybeTexture transmission_texture;
  bool has_volume = false;
  double thickness = 0.0;
  double attenuation_distance = 0.0;  ///< 0 means infinite
  glm::dvec3 attenuation_color{1.0};
  MaybeTexture thickness_texture;
  double anisotropy = 0.0, anisotropy_rotation = 0.0;
  MaybeTexture anisotropy_texture;
  double iridescence = 0.0, iridescence_ior = 1.3, iridescence_least = 100.0, iridescence_most = 400.0;
  MaybeTexture iridescence_texture, iridescence_thickness_texture;
  double dispersion = 0.0;
  double diffuse_transmission = 0.0;
  glm::dvec3 diffuse_transmission_color{1.0};
  MaybeTexture diffuse_transmission_texture, diffuse_transmission_color_texture;
  bool scatters = false;  ///< KHR_materials_volume_scatter

  /// Whether the surface bounds a solid; otherwise it is a thin sheet.
  bool is_volume() const { return has_volume && thickness > 0.0; }
};

/// Throws GltfError.
GltfMaterial parse_gltf_material(const JsonValue& material);
/// The material of primitives without one.
GltfMaterial default_gltf_material();

}  // namespace etendue
