#include "formats/mitsuba/mitsuba_materials.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "core/text.h"
#include "formats/mitsuba/named_materials.h"
#include "scene/limits.h"
#include "scene/metals.h"
#include "scene/parameters.h"

namespace etendue {

std::uint32_t MitsubaMaterials::row_of(const XmlElement& bsdf) {
  if (const auto found = rows_.find(&bsdf); found != rows_.end()) return found->second;
  const XmlAttribute *id = bsdf.find("id"), *type = bsdf.find("type");
  Material material{.bsdf = DiffuseBsdf{},
                    .name = id != nullptr     ? id->value
                            : type != nullptr ? type->value
                                              : "bsdf",
                    .position = context_.document.position(bsdf)};
  if (!open_.insert(&bsdf).second) {
    context_.sink.error(material.position, fmt::format("the material {} contains itself", text::quoted(material.name)));
    return default_row(false, material.position);
  }
  if (const auto object = MitsubaObject::read(bsdf, context_, "diffuse, grey")) {
    material.adapter = read_adapter(*object);
    if (!material.adapter) material.bsdf = read(*object);
  }
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

std::optional<Adapter> MitsubaMaterials::read_adapter(const MitsubaObject& object) {
  const std::string_view type = object.type();
  const bool turns = type == "normalmap" || type == "bumpmap";
  if (type == "phong" || type == "ward") return read_lobe(object);
  if (type == "mixturebsdf") return read_mixture(object);
  if (type == "coating" || type == "roughcoating") {
    context_.missing.add(fmt::format("bsdf {}", type), object.position(), "what it coats, without the coat");
    const std::vector<const XmlElement*> coated = object.children("bsdf");
    return MaskAdapter{1.0, coated.empty() ? default_row(false, object.position()) : row_of(*coated.front())};
  }
  if (type != "twosided" && type != "mask" && type != "blendbsdf" && !turns) return std::nullopt;
  std::vector<std::uint32_t> rows;
  for (const XmlElement* child : object.children("bsdf")) rows.push_back(row_of(*child));
  if (rows.empty()) rows.push_back(default_row(false, object.position()));  // has been reported
  if (type == "twosided") return TwoSidedAdapter{rows.front(), rows.back()};
  if (turns) return read_map(object, rows.front());
  const ScalarParameter share = share_of(object, type == "mask" ? "opacity" : "weight");
  if (type == "mask") return MaskAdapter{share, rows.front()};
  return BlendAdapter{share, rows.front(), rows.back()};
}

std::uint32_t MitsubaMaterials::add(Material material, const MitsubaObject& object) {
  material.name = object.type();
  material.position = object.position();
  scene_.materials.push_back(std::move(material));
  return static_cast<std::uint32_t>(scene_.materials.size() - 1);
}

/// A mixture of a diffuse base and a rough mirror. Their weights are in proportion to what they reflect, and their
/// colours are scaled so that each reflects as much as in the file.
Adapter MitsubaMaterials::read_lobe(const MitsubaObject& object) {
  const bool phong = object.type() == "phong";
  context_.missing.add(fmt::format("bsdf {}", object.type()), object.position(),
                       "a diffuse base and the lobe of a rough mirror");
  DiffuseBsdf base;
  RoughConductorBsdf mirror{.index = {glm::dvec3(0.0), glm::dvec3(1.0)}};
  assign(base.albedo, object, "diffuse_reflectance", SpectrumUse::reflectance);
  assign(mirror.specular_reflectance, object, "specular_reflectance", SpectrumUse::reflectance);
  const double slope = std::sqrt(2.0 / ((phong ? object.real("exponent") : 0.0) + 2.0));
  const auto roughness = [&](const char* name) {
    return std::clamp(phong ? slope : object.real(name), kMinRoughness, 1.0);
  };
  mirror.roughness = {.alpha_u = roughness("alpha_u"), .alpha_v = roughness("alpha_v")};
  const auto mean = [](const ColorParameter& c) {
    return (c.value.x + c.value.y + c.value.z) / (c.texture ? 6.0 : 3.0);  // assumes that a picture has a mean of 1/2
  };
  const double light = mean(base.albedo) + mean(mirror.specular_reflectance);
  const double weight = light > 0.0 ? std::clamp(mean(mirror.specular_reflectance) / light, 0.05, 0.95) : 0.5;
  base.albedo.value = glm::min(base.albedo.value / (1.0 - weight), glm::dvec3(1.0));
  mirror.specular_reflectance.value = glm::min(mirror.specular_reflectance.value / weight, glm::dvec3(1.0));
  const std::uint32_t first = add({.bsdf = base}, object), second = add({.bsdf = mirror}, object);
  return BlendAdapter{weight, first, second};
}

Adapter MitsubaMaterials::read_mixture(const MitsubaObject& object) {
  std::vector<double> weights = object.numbers("weights");
  std::vector<std::uint32_t> rows;
  for (const XmlElement* child : object.children("bsdf")) rows.push_back(row_of(*child));
  if (rows.empty() || weights.size() != rows.size()) {
    if (!rows.empty() && object.given("weights"))
      context_.sink.error(
          object.position_of("weights"),
          fmt::format("{} weights for {} materials; each needs exactly one", weights.size(), rows.size()));
    return MaskAdapter{1.0, default_row(false, object.position())};
  }
  double sum = 0.0;
  for (const double weight : weights) sum += weight;
  constexpr double kRounding = 1e-6;
  if (sum > 1.0 + kRounding)
    context_.sink.note(object.position_of("weights"),
                       fmt::format("the weights add up to {}; they are scaled to 1", sum));
  if (sum < 1.0 - kRounding) {
    weights.push_back(1.0 - sum);
    rows.push_back(default_row(true, object.position()));
  }
  // Materials are mixed in pairs: the mixture so far, and the next one.
  std::uint32_t mixed = rows.front();
  double total = weights.front();
  for (std::size_t i = 1; i < rows.size(); ++i) {
    total += weights[i];
    const BlendAdapter blend{total > 0.0 ? weights[i] / total : 0.0, mixed, rows[i]};
    if (i + 1 == rows.size()) return blend;
    mixed = add({.bsdf = DiffuseBsdf{}, .adapter = blend}, object);
  }
  return MaskAdapter{1.0, mixed};
}

Adapter MitsubaMaterials::read_map(const MitsubaObject& object, std::uint32_t inner) {
  const TurnedNormals turned{.mirrored = object.boolean("flip_invalid_normals"),
                             .shadowed = object.boolean("use_shadowing_function")};
  const Adapter none = MaskAdapter{1.0, inner};
  if (object.type() == "normalmap") {
    const XmlElement* map = object.texture("normalmap");
    const std::vector<const XmlElement*> unnamed = object.children("texture");  // allowed in 0.6
    if (map == nullptr && !unnamed.empty()) map = unnamed.front();
    if (map == nullptr) {
      context_.sink.error(object.position(), "normalmap needs a texture");
      return none;
    }
    ColorParameter normals = textures_.parameter({glm::dvec3(0.0), map});
    if (!normals.texture) normals = {glm::dvec3(1.0), textures_.add_constant(normals.value, object.position())};
    return NormalMapAdapter{normals, inner, false, turned};
  }
  const std::vector<const XmlElement*> maps = object.children("texture");  // may have any name
  if (maps.empty()) return none;                                           // has been reported
  ScalarParameter height = textures_.scalar(*maps.front());
  height.value *= object.real("scale");
  if (!height.texture) return none;  // a constant height has no bumps
  if (!std::holds_alternative<BitmapTexture>(scene_.textures[*height.texture].source)) {
    context_.missing.add("bumps of another texture than a bitmap", context_.document.position(*maps.front()),
                         "without bumps");
    return none;
  }
  return BumpMapAdapter{height, inner, turned};
}

ScalarParameter MitsubaMaterials::share_of(const MitsubaObject& object, const char* name) {
  const XmlElement* texture = object.texture(name);
  return texture != nullptr ? textures_.scalar(*texture) : ScalarParameter(object.real(name));
}

Bsdf MitsubaMaterials::read(const MitsubaObject& object) {
  const std::string_view type = object.type();
  if (type == "diffuse") return read_diffuse(object);
  if (type == "dielectric") return read_clear<DielectricBsdf>(object);
  if (type == "thindielectric") return read_clear<ThinDielectricBsdf>(object);
  if (type == "roughdielectric") {
    auto glass = read_clear<RoughDielectricBsdf>(object);
    read_roughness(object, glass.roughness);
    return glass;
  }
  if (type == "conductor") return read_conductor(object);
  if (type == "roughconductor") return read_rough_conductor(object);
  if (type == "plastic") return read_plastic<PlasticBsdf>(object);
  if (type == "roughplastic") return read_rough_plastic(object);
  if (type == "pplastic" || type == "roughdiffuse") return read_substitute(object);
  if (type == "null") return NullBsdf{};
  if (type == "principled") return read_principled<PrincipledBsdf>(object);
  if (type == "principledthin") return read_principled<PrincipledThinBsdf>(object);
  throw std::logic_error(fmt::format("the reader has no material {}", type));
}

template <typename Principled>
Bsdf MitsubaMaterials::read_principled(const MitsubaObject& object) {
  Principled bsdf;
  each_parameter(bsdf, [&](const char* name, auto& parameter) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(parameter)>, ColorParameter>) {
      assign(parameter, object, name, SpectrumUse::reflectance);
    } else {
      if (std::string_view(name) != "eta") parameter = share_of(object, name);
    }
  });
  if (const XmlElement* texture = object.texture("eta")) {
    bsdf.eta = textures_.scalar(*texture);
  } else if (object.given("eta")) {
    bsdf.eta = object.ior("eta");
  } else if constexpr (std::is_same_v<Principled, PrincipledBsdf>) {
    // From the reflectance at normal incidence. If that is 0, the smallest index that still refracts, which reflects
    // almost nothing.
    bsdf.eta = std::max(2.0 / (1.0 - std::sqrt(0.08 * object.real("specular"))) - 1.0, 1.0 + 1.1 * kMinIndexContrast);
  }
  return bsdf;
}

Bsdf MitsubaMaterials::read_substitute(const MitsubaObject& object) {
  const bool plastic = object.type() == "pplastic";
  context_.missing.add(fmt::format("bsdf {}", object.type()), object.position(), plastic ? "roughplastic" : "diffuse");
  return plastic ? read_rough_plastic(object) : read_diffuse(object);
}

Bsdf MitsubaMaterials::read_diffuse(const MitsubaObject& object) {
  DiffuseBsdf bsdf;
  const char* name = object.given("diffuse_reflectance") ? "diffuse_reflectance" : "reflectance";
  assign(bsdf.albedo, object, name, SpectrumUse::reflectance);
  return bsdf;
}

template <typename Glass>
Glass MitsubaMaterials::read_clear(const MitsubaObject& object) {
  Glass glass;
  glass.int_ior = object.ior("int_ior");
  glass.ext_ior = object.ior("ext_ior");
  assign(glass.specular_reflectance, object, "specular_reflectance", SpectrumUse::reflectance);
  assign(glass.specular_transmittance, object, "specular_transmittance", SpectrumUse::reflectance);
  return glass;
}

Bsdf MitsubaMaterials::read_conductor(const MitsubaObject& object) {
  ConductorBsdf bsdf;
  read_metal(object, bsdf.index);
  assign(bsdf.specular_reflectance, object, "specular_reflectance", SpectrumUse::reflectance);
  return bsdf;
}

Bsdf MitsubaMaterials::read_rough_conductor(const MitsubaObject& object) {
  RoughConductorBsdf bsdf;
  read_metal(object, bsdf.index);
  read_roughness(object, bsdf.roughness);
  assign(bsdf.specular_reflectance, object, "specular_reflectance", SpectrumUse::reflectance);
  return bsdf;
}

template <typename Plastic>
Plastic MitsubaMaterials::read_plastic(const MitsubaObject& object) {
  Plastic plastic;
  plastic.int_ior = object.ior("int_ior");
  plastic.ext_ior = object.ior("ext_ior");
  plastic.nonlinear = object.boolean("nonlinear");
  assign(plastic.diffuse_reflectance, object, "diffuse_reflectance", SpectrumUse::reflectance);
  assign(plastic.specular_reflectance, object, "specular_reflectance", SpectrumUse::reflectance);
  return plastic;
}

Bsdf MitsubaMaterials::read_rough_plastic(const MitsubaObject& object) {
  auto plastic = read_plastic<RoughPlasticBsdf>(object);
  plastic.distribution = read_distribution(object);
  assign_alpha(plastic.alpha, object, "alpha");
  return plastic;
}

void MitsubaMaterials::read_metal(const MitsubaObject& object, ConductorIndex& index) {
  const bool by_number = object.given("eta") || object.given("k");
  if (by_number) {
    assign(index.eta, object, "eta", SpectrumUse::index);
    assign(index.k, object, "k", SpectrumUse::index);
  } else {
    const bool copper = is_old() && !object.given("material");  // 0.6 has a different default
    const std::string name = copper ? "Cu" : object.text("material");
    const auto known = metal_index(name);
    if (known) index = *known;
    if (!known)
      context_.sink.error(object.position_of("material"),
                          fmt::format("there is no material {}{}; known are: {}", text::quoted(name),
                                      text::did_you_mean(name, metal_names()), text::join(metal_names())));
  }
  const double outside = is_old() && !object.given("ext_eta") ? *named_ior("air") : object.ior("ext_eta");
  const auto divide = [outside](auto& field) {
    if constexpr (requires { field.value; })
      field.value /= outside;
    else
      field /= outside;
  };
  divide(index.eta);
  divide(index.k);
}

Roughness::Distribution MitsubaMaterials::read_distribution(const MitsubaObject& object) {
  const std::string distribution = object.text("distribution");
  if (distribution == "ggx") return Roughness::Distribution::ggx;
  if (distribution != "beckmann")
    context_.missing.add(fmt::format("microfacet distribution {}", distribution), object.position_of("distribution"),
                         "beckmann");
  return Roughness::Distribution::beckmann;
}

void MitsubaMaterials::read_roughness(const MitsubaObject& object, Roughness& roughness) {
  roughness.distribution = read_distribution(object);
  assign_alpha(roughness.alpha_u, object, object.given("alpha_u") ? "alpha_u" : "alpha");
  assign_alpha(roughness.alpha_v, object, object.given("alpha_v") ? "alpha_v" : "alpha");
}

void MitsubaMaterials::assign(ColorParameter& field, const MitsubaObject& object, const char* name, SpectrumUse use) {
  field = textures_.parameter(object.color(name, use));
}

void MitsubaMaterials::assign(glm::dvec3& field, const MitsubaObject& object, const char* name, SpectrumUse use) {
  field = textures_.constant(object.color(name, use), fmt::format("{} of {}", name, object.type()).c_str());
}

void MitsubaMaterials::assign_alpha(ScalarParameter& field, const MitsubaObject& object, const char* name) {
  const XmlElement* texture = object.texture(name);
  field = texture != nullptr ? textures_.scalar(*texture) : ScalarParameter(alpha(object, name));
  if (!field.texture) field.value = std::max(field.value, kMinRoughness);
}

double MitsubaMaterials::alpha(const MitsubaObject& object, const char* name) {
  const double value = object.real(name);
  if (value >= kMinRoughness) return value;
  context_.sink.note(object.position_of(name),
                     fmt::format("roughness {} is raised to {}, the minimum", value, kMinRoughness));
  return kMinRoughness;
}

}  // namespace etendue
