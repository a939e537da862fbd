#include "formats/gltf/gltf_material.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

/// KHR_texture_transform: T R S, for coordinates with v downward. R turns counter-clockwise as the picture is seen.
glm::dmat3 transform_of(const JsonValue& extension) {
  const glm::dvec2 offset = vec2_or(extension, "offset", glm::dvec2(0.0));
  const glm::dvec2 scale = vec2_or(extension, "scale", glm::dvec2(1.0));
  const double angle = number_or(extension, "rotation", 0.0);
  const double c = std::cos(angle), s = std::sin(angle);
  return {glm::dvec3(c * scale.x, -s * scale.x, 0.0), glm::dvec3(s * scale.y, c * scale.y, 0.0),
          glm::dvec3(offset, 1.0)};
}

MaybeTexture find_texture(const JsonValue& object, std::string_view name) {
  const JsonValue* info = find_object(object, name);
  if (info == nullptr) return std::nullopt;
  const auto index = find_index(*info, "index");
  if (!index) throw GltfError{info, fmt::format("\"{}\" has no \"index\" of a texture", name)};
  GltfTextureInfo texture{.index = *index, .uv_set = find_index(*info, "texCoord").value_or(0), .where = info};
  if (const JsonValue* transform = find_extension(*info, "KHR_texture_transform")) {
    texture.transform = transform_of(*transform);
    texture.uv_set = find_index(*transform, "texCoord").value_or(texture.uv_set);
  }
  return texture;
}

/// A number clamped to its allowed range, as viewers do.
double clamped(const JsonValue& object, std::string_view name, double otherwise, double least, double most) {
  const double value = number_or(object, name, otherwise);
  return value < least ? least : value > most ? most : value;
}
double share(const JsonValue& object, std::string_view name, double otherwise) {
  return clamped(object, name, otherwise, 0.0, 1.0);
}
glm::dvec3 color(const JsonValue& object, std::string_view name, const glm::dvec3& otherwise) {
  return glm::clamp(vec3_or(object, name, otherwise), 0.0, 1.0);
}

void read_alpha(const JsonValue& json, GltfMaterial& m) {
  const std::string mode = string_or(json, "alphaMode", "OPAQUE");
  if (mode == "MASK") {
    m.alpha = GltfMaterial::Alpha::mask;
  } else if (mode == "BLEND") {
    m.alpha = GltfMaterial::Alpha::blend;
  } else if (mode != "OPAQUE") {
    throw GltfError{&json,
                    fmt::format("the alpha mode {} is unknown; modes are OPAQUE, MASK and BLEND", text::quoted(mode))};
  }
  m.alpha_cutoff = number_or(json, "alphaCutoff", 0.5);
  m.double_sided = bool_or(json, "doubleSided", false);
}

void read_base(const JsonValue& json, GltfMaterial& m) {
  if (const JsonValue* base = find_object(json, "pbrMetallicRoughness")) {
    m.base_color = glm::clamp(vec4_or(*base, "baseColorFactor", glm::dvec4(1.0)), 0.0, 1.0);
    m.metallic = share(*base, "metallicFactor", 1.0);
    m.roughness = share(*base, "roughnessFactor", 1.0);
    m.base_color_texture = find_texture(*base, "baseColorTexture");
    m.metallic_roughness_texture = find_texture(*base, "metallicRoughnessTexture");
  }
  if (const JsonValue* glossy = find_extension(json, "KHR_materials_pbrSpecularGlossiness")) {
    m.model = GltfMaterial::Model::specular_glossiness;
    m.base_color = glm::clamp(vec4_or(*glossy, "diffuseFactor", glm::dvec4(1.0)), 0.0, 1.0);
    m.base_color_texture = find_texture(*glossy, "diffuseTexture");
    m.specular_factor = color(*glossy, "specularFactor", glm::dvec3(1.0));
    m.glossiness = share(*glossy, "glossinessFactor", 1.0);
    m.specular_glossiness_texture = find_texture(*glossy, "specularGlossinessTexture");
  }
  if (find_extension(json, "KHR_materials_unlit") != nullptr) m.model = GltfMaterial::Model::unlit;
}

void read_surface(const JsonValue& json, GltfMaterial& m) {
  m.normal_texture = find_texture(json, "normalTexture");
  if (m.normal_texture) m.normal_scale = number_or(*m.normal_texture->where, "scale", 1.0);
  m.occlusion_texture = find_texture(json, "occlusionTexture");
  m.emission = glm::max(vec3_or(json, "emissiveFactor", glm::dvec3(0.0)), 0.0);
  m.emission_texture = find_texture(json, "emissiveTexture");
  if (const JsonValue* strength = find_extension(json, "KHR_materials_emissive_strength"))
    m.emission *= std::max(number_or(*strength, "emissiveStrength", 1.0), 0.0);
}

void read_layers(const JsonValue& json, GltfMaterial& m) {
  if (const JsonValue* e = find_extension(json, "KHR_materials_clearcoat")) {
    m.clearcoat = share(*e, "clearcoatFactor", 0.0);
    m.clearcoat_roughness = share(*e, "clearcoatRoughnessFactor", 0.0);
    m.clearcoat_texture = find_texture(*e, "clearcoatTexture");
    m.clearcoat_roughness_texture = find_texture(*e, "clearcoatRoughnessTexture");
    m.clearcoat_normal_texture = find_texture(*e, "clearcoatNormalTexture");
    if (m.clearcoat_normal_texture)
      m.clearcoat_normal_scale = number_or(*m.clearcoat_normal_texture->where, "scale", 1.0);
  }
  if (const JsonValue* e = find_extension(json, "KHR_materials_sheen")) {
    m.sheen_color = color(*e, "sheenColorFactor", glm::dvec3(0.0));
    m.sheen_roughness = share(*e, "sheenRoughnessFactor", 0.0);
    m.sheen_color_texture = find_texture(*e, "sheenColorTexture");
    m.sheen_roughness_texture = find_texture(*e, "sheenRoughnessTexture");
  }
  if (const JsonValue* e = find_extension(json, "KHR_materials_specular")) {
    m.specular = share(*e, "specularFactor", 1.0);
    m.specular_color = glm::max(vec3_or(*e, "specularColorFactor", glm::dvec3(1.0)), 0.0);
    m.specular_texture = find_texture(*e, "specularTexture");
    m.specular_color_texture = find_texture(*e, "specularColorTexture");
  }
  if (const JsonValue* e = find_extension(json, "KHR_materials_iridescence")) {
    m.iridescence = share(*e, "iridescenceFactor", 0.0);
    m.iridescence_ior = clamped(*e, "iridescenceIor", 1.3, 1.0, 10.0);
    m.iridescence_least = std::max(number_or(*e, "iridescenceThicknessMinimum", 100.0), 0.0);
    m.iridescence_most = std::max(number_or(*e, "iridescenceThicknessMaximum", 400.0), 0.0);
    m.iridescence_texture = find_texture(*e, "iridescenceTexture");
    m.iridescence_thickness_texture = find_texture(*e, "iridescenceThicknessTexture");
  }
  if (const JsonValue* e = find_extension(json, "KHR_materials_anisotropy")) {
    m.anisotropy = share(*e, "anisotropyStrength", 0.0);
    m.anisotropy_rotation = number_or(*e, "anisotropyRotation", 0.0);
    m.anisotropy_texture = find_texture(*e, "anisotropyTexture");
  }
}

void read_transmission(const JsonValue& json, GltfMaterial& m) {
  // 0 stands for an infinite index.
  if (const JsonValue* e = find_extension(json, "KHR_materials_ior")) m.ior = number_or(*e, "ior", 1.5);
  if (const JsonValue* e = find_extension(json, "KHR_materials_transmission")) {
    m.transmission = share(*e, "transmissionFactor", 0.0);
    m.transmission_texture = find_texture(*e, "transmissionTexture");
  }
  if (const JsonValue* e = find_extension(json, "KHR_materials_volume")) {
    m.has_volume = true;
    m.thickness = std::max(number_or(*e, "thicknessFactor", 0.0), 0.0);
    m.attenuation_distance = std::max(number_or(*e, "attenuationDistance", 0.0), 0.0);
    m.attenuation_color = color(*e, "attenuationColor", glm::dvec3(1.0));
    m.thickness_texture = find_texture(*e, "thicknessTexture");
  }
  if (const JsonValue* e = find_extension(json, "KHR_materials_dispersion"))
    m.dispersion = std::max(number_or(*e, "dispersion", 0.0), 0.0);
  if (const JsonValue* e = find_extension(json, "KHR_materials_diffuse_transmission")) {
    m.diffuse_transmission = share(*e, "diffuseTransmissionFactor", 0.0);
    m.diffuse_transmission_color = color(*e, "diffuseTransmissionColorFactor", glm::dvec3(1.0));
    m.diffuse_transmission_texture = find_texture(*e, "diffuseTransmissionTexture");
    m.diffuse_transmission_color_texture = find_texture(*e, "diffuseTransmissionColorTexture");
  }
  m.scatters = find_extension(json, "KHR_materials_volume_scatter") != nullptr;
}

}  // namespace

GltfMaterial parse_gltf_material(const JsonValue& material) {
  GltfMaterial m;
  m.name = string_or(material, "name", "");
  m.where = &material;
  read_alpha(material, m);
  read_base(material, m);
  read_surface(material, m);
  read_layers(material, m);
  read_transmission(material, m);
  return m;
}

GltfMaterial default_gltf_material() {
  GltfMaterial m;
  m.name = "default";
  return m;
}

}  // namespace etendue
