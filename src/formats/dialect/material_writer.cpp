#include "formats/dialect/material_writer.h"

#include <algorithm>
#include <map>
#include <variant>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "scene/materials.h"

namespace etendue {

void MaterialWriter::refuse(const std::string& what) const {
  const std::string& scene = scene_.file.empty() ? scene_.name : scene_.file;
  throw Error(ErrorKind::scene, fmt::format("{}: {}, {}; nothing is written", scene, what, words_.lacking));
}

void MaterialWriter::color(const char* name, const ColorParameter& parameter) {
  if (!parameter.texture) return color(name, parameter.value);
  write_texture(name, *parameter.texture, parameter.value, std::nullopt);
}

void MaterialWriter::number(const char* name, const ScalarParameter& parameter) {
  if (!parameter.texture) return number(name, parameter.value);
  write_texture(name, *parameter.texture, glm::dvec3(parameter.value), parameter.channel);
}

std::uint32_t MaterialWriter::uv_set_of(const Instance& instance) const {
  std::map<std::uint32_t, std::string> users;  // one of each set
  const auto look = [&](const char*, const auto& parameter) {
    if (!parameter.texture) return;
    const Texture& texture = scene_.textures[*parameter.texture];
    if (!std::holds_alternative<AttributeTexture>(texture.source))
      users.try_emplace(texture.uv_set, "the texture " + text::quoted(texture.name));
  };
  each_material(scene_, instance.material, [&](const Material& material) {
    each_parameter(material, look);
    if (is_aligned(material)) users.try_emplace(0, "the direction of " + text::quoted(material.name));
  });
  if (const AreaEmitter* emitter = scene_.emitter_of(instance)) each_parameter(*emitter, look);
  if (users.size() > 1)
    refuse(fmt::format("{} uses several sets of texture coordinates (set {} for {}, set {} for {})",
                       text::quoted(instance.name), users.begin()->first, users.begin()->second, users.rbegin()->first,
                       users.rbegin()->second));
  return users.empty() ? 0 : users.begin()->first;
}

std::string MaterialWriter::material_id(std::uint32_t row) const {
  if (!keeps_names_) return fmt::format("material-{}", row);
  const std::string& name = scene_.materials[row].name;
  const bool alone = std::ranges::count(scene_.materials, name, &Material::name) == 1;
  return alone ? name : fmt::format("{}-{}", name, row);
}

std::string MaterialWriter::material_alone(std::uint32_t row) {
  keeps_names_ = true;
  for (const Texture& texture : scene_.textures) {
    if (const auto* source = std::get_if<BitmapTexture>(&texture.source))
      files_.know(scene_.bitmaps[source->bitmap], texture.name);
  }
  write_material(row);
  return xml_.elements();
}

void MaterialWriter::write_materials() {
  for (const Instance& instance : scene_.instances) write_material(instance.material);
}

void MaterialWriter::write_material(std::uint32_t row) {
  if (!written_.insert(row).second) return;
  const Material& material = scene_.materials[row];
  if (material.adapter) {
    each_choice(*material.adapter, [&](std::uint32_t choice) { write_material(choice); });
    std::visit([&](const auto& adapter) { write_adapter(material_id(row), adapter); }, *material.adapter);
  } else {
    std::visit([&](const auto& bsdf) { write_bsdf(material_id(row), bsdf); }, material.bsdf);
  }
  xml_.close();
}

template <typename Metal>
void MaterialWriter::write_metal(const Metal& bsdf) {
  color("eta", bsdf.index.eta);
  color("k", bsdf.index.k);
  color("specular_reflectance", bsdf.specular_reflectance);
}

template <typename Glass>
void MaterialWriter::write_clear(const Glass& bsdf) {
  write_indices(bsdf);
  color("specular_reflectance", bsdf.specular_reflectance);
  color("specular_transmittance", bsdf.specular_transmittance);
}

template <typename Plastic>
void MaterialWriter::write_plastic(const Plastic& bsdf) {
  write_indices(bsdf);
  color("diffuse_reflectance", bsdf.diffuse_reflectance);
  color("specular_reflectance", bsdf.specular_reflectance);
  xml_.boolean("nonlinear", bsdf.nonlinear);
}

void MaterialWriter::write_distribution(Roughness::Distribution distribution) {
  xml_.text("distribution", distribution == Roughness::Distribution::ggx ? "ggx" : "beckmann");
}

void MaterialWriter::write_roughness(const Roughness& roughness) {
  write_distribution(roughness.distribution);
  number("alpha_u", roughness.alpha_u);
  number("alpha_v", roughness.alpha_v);
}

void MaterialWriter::write_adapter(const std::string& id, const TwoSidedAdapter& adapter) {
  open_bsdf(id, "twosided");
  refer_to(adapter.front);
  if (adapter.back != adapter.front) refer_to(adapter.back);
}

void MaterialWriter::write_adapter(const std::string& id, const MaskAdapter& mask) {
  open_bsdf(id, "mask");
  number("opacity", mask.opacity);
  refer_to(mask.inner);
}

void MaterialWriter::write_turned(const TurnedNormals& turned) {
  if (!turned.mirrored) xml_.boolean("flip_invalid_normals", false);
  if (!turned.shadowed) xml_.boolean("use_shadowing_function", false);
}

void MaterialWriter::write_adapter(const std::string& id, const NormalMapAdapter& map) {
  open_bsdf(id, "normalmap");
  color("normalmap", map.normals);
  if (map.vertex_tangents) write_vertex_tangents();
  write_turned(map.turned);
  refer_to(map.inner);
}

void MaterialWriter::write_adapter(const std::string& id, const BumpMapAdapter& map) {
  open_bsdf(id, "bumpmap");
  ScalarParameter height = map.height;
  height.value = 1.0;
  number("displacement", height);
  number("scale", map.height.value);
  write_turned(map.turned);
  refer_to(map.inner);
}

void MaterialWriter::write_adapter(const std::string& id, const BlendAdapter& blend) {
  open_bsdf(id, words_.blend);
  number("weight", blend.weight);
  refer_to(blend.first);
  refer_to(blend.second);
}

void MaterialWriter::write_bsdf(const std::string& id, const DiffuseBsdf& bsdf) {
  open_bsdf(id, "diffuse");
  color(words_.albedo, bsdf.albedo);
}

void MaterialWriter::write_bsdf(const std::string& id, const MirrorBsdf&) {
  open_bsdf(id, words_.mirror);
}

void MaterialWriter::write_bsdf(const std::string& id, const PrincipledBsdf& bsdf) {
  open_bsdf(id, "principled");
  write_parameters(bsdf);
}

void MaterialWriter::write_bsdf(const std::string& id, const PrincipledThinBsdf& bsdf) {
  open_bsdf(id, "principledthin");
  write_parameters(bsdf);
}

void MaterialWriter::write_bsdf(const std::string& id, const NullBsdf&) {
  open_bsdf(id, "null");
}

void MaterialWriter::write_bsdf(const std::string& id, const DielectricBsdf& bsdf) {
  open_bsdf(id, "dielectric");
  is_tinted(bsdf) ? write_clear(bsdf) : write_indices(bsdf);
}

void MaterialWriter::write_bsdf(const std::string& id, const ConductorBsdf& bsdf) {
  open_bsdf(id, "conductor");
  write_metal(bsdf);
}

void MaterialWriter::write_bsdf(const std::string& id, const RoughConductorBsdf& bsdf) {
  open_bsdf(id, "roughconductor");
  write_metal(bsdf);
  write_roughness(bsdf.roughness);
}

void MaterialWriter::write_bsdf(const std::string& id, const RoughDielectricBsdf& bsdf) {
  open_bsdf(id, "roughdielectric");
  write_clear(bsdf);
  write_roughness(bsdf.roughness);
}

void MaterialWriter::write_bsdf(const std::string& id, const ThinDielectricBsdf& bsdf) {
  open_bsdf(id, "thindielectric");
  write_clear(bsdf);
}

void MaterialWriter::write_bsdf(const std::string& id, const PlasticBsdf& bsdf) {
  open_bsdf(id, "plastic");
  write_plastic(bsdf);
}

void MaterialWriter::write_bsdf(const std::string& id, const RoughPlasticBsdf& bsdf) {
  open_bsdf(id, "roughplastic");
  write_plastic(bsdf);
  write_distribution(bsdf.distribution);
  number("alpha", bsdf.alpha);
}

}  // namespace etendue
