#include "formats/mitsuba/mitsuba_materials.h"

#include <stdexcept>

#include <fmt/format.h>

#include "core/text.h"
#include "scene/limits.h"
#include "scene/metals.h"

namespace etendue {

std::uint32_t MitsubaMaterials::row_of(const XmlElement& bsdf) {
  if (const auto found = rows_.find(&bsdf); found != rows_.end()) return found->second;
  const XmlAttribute *id = bsdf.find("id"), *type = bsdf.find("type");
  Material material{.bsdf = read(bsdf),
                    .name = id != nullptr     ? id->value
                            : type != nullptr ? type->value
                                              : "bsdf",
                    .position = context_.document.position(bsdf)};
  const auto row = static_cast<std::uint32_t>(scene_.materials.size());
  scene_.materials.push_back(std::move(material));
  rows_.emplace(&bsdf, row);
  return row;
}

std::uint32_t MitsubaMaterials::default_row(bool emits, const SourcePosition& shape) {
  std::optional<std::uint32_t>& row = emits ? black_ : grey_;
  if (row) return *row;
  row = static_cast<std::uint32_t>(scene_.materials.size());
  scene_.materials.push_back(
      {.bsdf = DiffuseBsdf{glm::dvec3(emits ? 0.0 : 0.5)}, .name = "diffuse", .position = shape});
  return *row;
}

glm::dvec3 MitsubaMaterials::constant(const MitsubaColor& color) {
  if (color.texture == nullptr) return color.value;
  const XmlAttribute* type = color.texture->find("type");
  context_.missing.add(fmt::format("texture {}", type == nullptr ? "without a type" : type->value),
                       context_.document.position(*color.texture), "grey, 0.5");
  return glm::dvec3(0.5);
}

Bsdf MitsubaMaterials::read(const XmlElement& element) {
  const auto object = MitsubaObject::read(element, context_, "diffuse, grey");
  if (!object) return DiffuseBsdf{};
  const std::string_view type = object->type();
  if (type == "diffuse") return read_diffuse(*object);
  if (type == "dielectric") return read_dielectric(*object);
  if (type == "conductor") return read_conductor(*object);
  if (type == "roughconductor") return read_rough_conductor(*object);
  throw std::logic_error(fmt::format("the reader has no material {}", type));
}

Bsdf MitsubaMaterials::read_diffuse(const MitsubaObject& object) {
  const char* name = object.given("diffuse_reflectance") ? "diffuse_reflectance" : "reflectance";
  return DiffuseBsdf{constant(object.color(name, SpectrumUse::reflectance))};
}

Bsdf MitsubaMaterials::read_dielectric(const MitsubaObject& object) {
  require_white(object, "specular_reflectance");
  require_white(object, "specular_transmittance");
  return DielectricBsdf{object.ior("int_ior"), object.ior("ext_ior")};
}

Bsdf MitsubaMaterials::read_conductor(const MitsubaObject& object) {
  return ConductorBsdf{read_metal(object), constant(object.color("specular_reflectance", SpectrumUse::reflectance))};
}

Bsdf MitsubaMaterials::read_rough_conductor(const MitsubaObject& object) {
  return RoughConductorBsdf{read_metal(object), read_roughness(object),
                            constant(object.color("specular_reflectance", SpectrumUse::reflectance))};
}

ConductorIndex MitsubaMaterials::read_metal(const MitsubaObject& object) {
  ConductorIndex index;
  if (object.given("eta") || object.given("k")) {
    index.eta = constant(object.color("eta", SpectrumUse::index));
    index.k = constant(object.color("k", SpectrumUse::index));
  } else {
    const std::string name = object.text("material");
    const auto known = metal_index(name);
    if (known) index = *known;
    if (!known)
      context_.sink.error(object.position_of("material"),
                          fmt::format("there is no material {}{}; known are: {}", text::quoted(name),
                                      text::did_you_mean(name, metal_names()), text::join(metal_names())));
  }
  const double outside = object.ior("ext_eta");
  return {index.eta / outside, index.k / outside};
}

Roughness MitsubaMaterials::read_roughness(const MitsubaObject& object) {
  Roughness roughness;
  const std::string distribution = object.text("distribution");
  if (distribution == "ggx") {
    roughness.distribution = Roughness::Distribution::ggx;
  } else if (distribution != "beckmann") {
    context_.missing.add(fmt::format("microfacet distribution {}", distribution), object.position_of("distribution"),
                         "beckmann");
  }
  roughness.alpha_u = alpha(object, object.given("alpha_u") ? "alpha_u" : "alpha");
  roughness.alpha_v = alpha(object, object.given("alpha_v") ? "alpha_v" : "alpha");
  return roughness;
}

double MitsubaMaterials::alpha(const MitsubaObject& object, const char* name) {
  if (const XmlElement* texture = object.texture(name)) return constant({glm::dvec3(0.0), texture}).x;
  const double value = object.real(name);
  if (value >= kMinRoughness) return value;
  context_.sink.note(object.position_of(name),
                     fmt::format("roughness {} is taken as {}, the least there is", value, kMinRoughness));
  return kMinRoughness;
}

void MitsubaMaterials::require_white(const MitsubaObject& object, const char* name) {
  if (!object.given(name)) return;
  const MitsubaColor color = object.color(name, SpectrumUse::reflectance);
  if (color.texture == nullptr && color.value == glm::dvec3(1.0)) return;
  context_.missing.add(fmt::format("{} of {}", name, object.type()), object.position_of(name), "1");
}

}  // namespace etendue
