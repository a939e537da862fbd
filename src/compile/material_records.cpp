#include "compile/material_records.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>

#include "compile/coats.h"
#include "core/parallel.h"
#include "scene/limits.h"
#include "scene/materials.h"
#include "scene/parameters.h"

namespace etendue {
namespace {

gpu::MaterialRecord flatten(const DiffuseBsdf& bsdf) {
  return {.params = glm::vec3(bsdf.albedo.value), .header = gpu::kBsdfDiffuse | gpu::kMaterialOneSided};
}
gpu::MaterialRecord flatten(const MirrorBsdf&) {
  return {.header = gpu::kBsdfMirror | gpu::kMaterialDelta | gpu::kMaterialOneSided};
}
gpu::MaterialRecord flatten(const DielectricBsdf& bsdf) {
  if (is_tinted(bsdf))
    return {.params = glm::vec3(bsdf.specular_transmittance.value),
            .header = gpu::kBsdfTintedDielectric | gpu::kMaterialDelta,
            .specular = glm::vec3(bsdf.specular_reflectance.value),
            .eta = glm::vec3(bsdf.int_ior, bsdf.ext_ior, 0.0)};
  return {.params = glm::vec3(bsdf.int_ior, bsdf.ext_ior, 0.0), .header = gpu::kBsdfDielectric | gpu::kMaterialDelta};
}
gpu::MaterialRecord flatten(const NullBsdf&) {
  return {.header = gpu::kBsdfNull | gpu::kMaterialDelta};
}
// Rows are integers below 2^24, which floats represent exactly.
gpu::MaterialRecord flatten(const TwoSidedAdapter& adapter) {
  return {.params = glm::vec3(adapter.front, adapter.back, 0.0f), .header = gpu::kAdapterTwoSided};
}
gpu::MaterialRecord flatten(const MaskAdapter& mask) {
  return {.params = glm::vec3(static_cast<float>(mask.inner), 0.0f, mask.opacity.value), .header = gpu::kAdapterMask};
}
gpu::MaterialRecord flatten(const BlendAdapter& blend) {
  return {.params = glm::vec3(static_cast<float>(blend.first), blend.second, blend.weight.value),
          .header = gpu::kAdapterBlend};
}
gpu::uint map_bits(const TurnedNormals& turned) {
  return (turned.mirrored ? 0u : gpu::kMapUnmirrored) | (turned.shadowed ? 0u : gpu::kMapUnshadowed);
}
gpu::MaterialRecord flatten(const NormalMapAdapter& map) {
  const gpu::uint bits = map_bits(map.turned) | (map.vertex_tangents ? gpu::kMapVertexTangents : 0u);
  return {.params = glm::vec3(static_cast<float>(map.inner), static_cast<float>(bits), 0.0f),
          .header = gpu::kAdapterNormalMap};
}
gpu::MaterialRecord flatten(const BumpMapAdapter& map) {
  return {.params = glm::vec3(static_cast<float>(map.inner), map_bits(map.turned), map.height.value),
          .header = gpu::kAdapterBumpMap};
}
gpu::MaterialRecord flatten(const PrincipledBsdf& bsdf) {
  return {.params = glm::vec3(bsdf.base_color.value),
          .header = gpu::kBsdfPrincipled | (may_refract(bsdf) ? gpu::kMaterialTransmissive : gpu::kMaterialOneSided),
          .specular = glm::vec3(bsdf.metallic.value, bsdf.spec_trans.value, bsdf.spec_tint.value),
          .share = static_cast<float>(bsdf.anisotropic.value),
          .eta = glm::vec3(bsdf.eta.value, bsdf.roughness.value, bsdf.flatness.value),
          .alpha_u = static_cast<float>(bsdf.clearcoat_gloss.value),
          .k = glm::vec3(bsdf.sheen.value, bsdf.sheen_tint.value, bsdf.clearcoat.value)};
}
gpu::MaterialRecord flatten(const PrincipledThinBsdf& bsdf) {
  return {.params = glm::vec3(bsdf.base_color.value),
          .header = gpu::kBsdfPrincipledThin | gpu::kMaterialTransmissive,
          .specular = glm::vec3(bsdf.diff_trans.value, bsdf.spec_trans.value, bsdf.spec_tint.value),
          .share = static_cast<float>(bsdf.anisotropic.value),
          .eta = glm::vec3(bsdf.eta.value, bsdf.roughness.value, bsdf.flatness.value),
          .k = glm::vec3(bsdf.sheen.value, bsdf.sheen_tint.value, 0.0)};
}
// Tabulated once per process.
const std::vector<float>& sheen_table() {
  static const std::vector<float> table = sheen_albedos();
  return table;
}
// Half the difference of the indices for red and blue at a dispersion of 1, relative to the index minus 1
// [Khronos2021].
constexpr double kHalfSpread = 0.025;
// A negative exponent of a solid's transmittance, per scene unit.
glm::dvec3 absorption(const GltfBsdf& bsdf) {
  return bsdf.thin ? glm::dvec3(0.0) : -glm::log(bsdf.attenuation_color) / bsdf.attenuation_distance;
}
gpu::MaterialRecord flatten(const GltfBsdf& bsdf, std::vector<gpu::vec4>& tables) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double turn = bsdf.anisotropy_rotation / kTurn;
  const bool has_film = bsdf.iridescence.texture || bsdf.iridescence.value > 0.0;
  const bool absorbs = absorption(bsdf) != glm::dvec3(0.0);
  const gpu::MaterialRecord record{
      .params = glm::vec3(bsdf.base_color.value),
      .header = gpu::kBsdfGltf | (may_refract(bsdf) ? gpu::kMaterialTransmissive : gpu::kMaterialOneSided) |
                (absorbs ? gpu::kMaterialVolume : 0u) | (has_film ? gpu::kMaterialFilm : 0u) |
                (disperses(bsdf) ? gpu::kMaterialDispersive : 0u) |
                (bsdf.coat_keeps_normal ? gpu::kMaterialCoatNormal : 0u),
      .specular = glm::vec3(bsdf.specular_color.value),
      .share = static_cast<float>(bsdf.specular.value),
      .eta = glm::vec3(bsdf.ior.value, bsdf.roughness.value, bsdf.metallic.value),
      .alpha_u = static_cast<float>(bsdf.anisotropy.value),
      .k = glm::vec3(bsdf.transmission.value, bsdf.diffuse_transmission.value, bsdf.clearcoat.value),
      .alpha_v = static_cast<float>(bsdf.clearcoat_roughness.value),
      .sheen = glm::vec4(glm::vec3(bsdf.sheen_color.value), static_cast<float>(bsdf.sheen_roughness.value)),
      .scattered =
          glm::vec4(glm::vec3(bsdf.diffuse_transmission_color.value), static_cast<float>(bsdf.iridescence.value)),
      .film = glm::vec4(bsdf.iridescence_ior.value, bsdf.iridescence_thickness.value, turn - std::floor(turn),
                        tables.size()),
      .volume = glm::vec4(glm::vec3(absorption(bsdf)),
                          bsdf.thin ? 0.0 : 1.0 + (disperses(bsdf) ? kHalfSpread * bsdf.dispersion : 0.0))};
  if (bsdf.sheen_color.value == glm::dvec3(0.0)) return record;
  const std::vector<float>& sheen = sheen_table();
  for (std::size_t i = 0; i < sheen.size(); i += 4)
    tables.emplace_back(sheen[i], sheen[i + 1], sheen[i + 2], sheen[i + 3]);
  return record;
}
gpu::uint distribution_flag(Roughness::Distribution distribution) {
  return distribution == Roughness::Distribution::beckmann ? gpu::kMaterialBeckmann : 0u;
}
gpu::MaterialRecord flatten(const MicrofacetBsdf& bsdf) {
  const double share = 1.0 - std::max({bsdf.kd.value.x, bsdf.kd.value.y, bsdf.kd.value.z});
  return {.params = glm::vec3(bsdf.kd.value),
          .header = gpu::kBsdfMicrofacet | gpu::kMaterialOneSided | gpu::kMaterialBeckmann,
          .specular = glm::vec3(glm::dvec3(share)),
          .share = static_cast<float>(share),
          .eta = glm::vec3(bsdf.int_ior, bsdf.ext_ior, 0.0),
          .alpha_u = static_cast<float>(bsdf.alpha.value),
          .alpha_v = static_cast<float>(bsdf.alpha.value)};
}
gpu::MaterialRecord flatten(const ConductorBsdf& bsdf) {
  return {.header = gpu::kBsdfConductor | gpu::kMaterialDelta | gpu::kMaterialOneSided,
          .specular = glm::vec3(bsdf.specular_reflectance.value),
          .eta = glm::vec3(bsdf.index.eta.value),
          .k = glm::vec3(bsdf.index.k.value)};
}
gpu::MaterialRecord flatten(const RoughConductorBsdf& bsdf) {
  return {.header = gpu::kBsdfRoughConductor | gpu::kMaterialOneSided | distribution_flag(bsdf.roughness.distribution),
          .specular = glm::vec3(bsdf.specular_reflectance.value),
          .share = 1.0f,
          .eta = glm::vec3(bsdf.index.eta.value),
          .alpha_u = static_cast<float>(bsdf.roughness.alpha_u.value),
          .k = glm::vec3(bsdf.index.k.value),
          .alpha_v = static_cast<float>(bsdf.roughness.alpha_v.value)};
}

gpu::MaterialRecord flatten(const RoughDielectricBsdf& bsdf) {
  return {
      .params = glm::vec3(bsdf.specular_transmittance.value),
      .header = gpu::kBsdfRoughDielectric | gpu::kMaterialTransmissive | distribution_flag(bsdf.roughness.distribution),
      .specular = glm::vec3(bsdf.specular_reflectance.value),
      .eta = glm::vec3(bsdf.int_ior, bsdf.ext_ior, 0.0),
      .alpha_u = static_cast<float>(bsdf.roughness.alpha_u.value),
      .alpha_v = static_cast<float>(bsdf.roughness.alpha_v.value)};
}
gpu::MaterialRecord flatten(const ThinDielectricBsdf& bsdf) {
  return {.params = glm::vec3(bsdf.specular_transmittance.value),
          .header = gpu::kBsdfThinDielectric | gpu::kMaterialDelta,
          .specular = glm::vec3(bsdf.specular_reflectance.value),
          .eta = glm::vec3(bsdf.int_ior, bsdf.ext_ior, 0.0)};
}

// Share of the samples for the coat, apart from Fresnel's factor.
template <typename Plastic>
float coat_share(const Plastic& bsdf) {
  const auto mean = [](const glm::dvec3& c) { return (c.x + c.y + c.z) / 3.0; };
  const double coat = mean(bsdf.specular_reflectance.value), base = mean(bsdf.diffuse_reflectance.value);
  return static_cast<float>(coat + base > 0.0 ? coat / (coat + base) : 1.0);
}
template <typename Plastic>
gpu::MaterialRecord flatten_plastic(const Plastic& bsdf, double reflectance_inside) {
  const double ratio = bsdf.ext_ior / bsdf.int_ior;
  return {.params = glm::vec3(bsdf.diffuse_reflectance.value),
          .header = gpu::kMaterialOneSided | (bsdf.nonlinear ? gpu::kMaterialNonlinear : 0u),
          .specular = glm::vec3(bsdf.specular_reflectance.value),
          .share = coat_share(bsdf),
          .eta = glm::vec3(bsdf.int_ior, bsdf.ext_ior, 0.0),
          .k = glm::vec3(reflectance_inside, ratio * ratio, 0.0)};
}
gpu::MaterialRecord flatten(const PlasticBsdf& bsdf) {
  gpu::MaterialRecord record = flatten_plastic(bsdf, diffuse_reflectance_inside(bsdf.int_ior / bsdf.ext_ior));
  record.header |= gpu::kBsdfPlastic;
  return record;
}
gpu::MaterialRecord flatten(const RoughPlasticBsdf& bsdf, std::vector<gpu::vec4>& tables) {
  const auto coat_of = [&](double alpha) {
    return rough_coat({bsdf.distribution, alpha, alpha}, bsdf.int_ior / bsdf.ext_ior);
  };
  const auto add_table = [&](const RoughCoat& coat) {
    for (std::size_t i = 0; i < coat.transmittances.size(); i += 4)
      tables.emplace_back(coat.transmittances[i], coat.transmittances[i + 1], coat.transmittances[i + 2],
                          coat.transmittances[i + 3]);
  };
  const auto first = static_cast<float>(tables.size());
  double inside = 0.0;
  if (bsdf.alpha.texture) {
    std::vector<RoughCoat> coats(gpu::kCoatRoughnesses);
    parallel_for(coats.size(), 1, [&](std::uint64_t i, std::uint64_t) {
      const double root = static_cast<double>(i) / (gpu::kCoatRoughnesses - 1);
      coats[i] = coat_of(std::max(root * root, kMinRoughness));
    });
    for (const RoughCoat& coat : coats) {
      add_table(coat);
      tables.emplace_back(coat.reflectance_inside, 0.0f, 0.0f, 0.0f);
    }
  } else {
    const RoughCoat coat = coat_of(bsdf.alpha.value);
    add_table(coat);
    inside = coat.reflectance_inside;
  }
  gpu::MaterialRecord record = flatten_plastic(bsdf, inside);
  record.header |= gpu::kBsdfRoughPlastic | distribution_flag(bsdf.distribution);
  record.eta.z = bsdf.alpha.texture ? 1.0f : 0.0f;
  record.alpha_u = record.alpha_v = static_cast<float>(bsdf.alpha.value);
  record.k.z = first;
  return record;
}

// Bits of the floats of a record: a number of texel `texel`, and a colour at its beginning.
constexpr gpu::uint number_at(gpu::uint texel, gpu::uint place) {
  return 1u << (4 * texel + place);
}
constexpr gpu::uint color_at(gpu::uint texel) {
  return 7u << (4 * texel);
}
struct Place {
  std::string_view name;
  gpu::uint floats;
};

// Where flatten() stores the parameters, by their names in each_parameter().
constexpr Place kPlaces[] = {
    {"albedo", color_at(0)},
    {"kd", color_at(0)},
    {"diffuse_reflectance", color_at(0)},
    {"specular_transmittance", color_at(0)},
    {"specular_reflectance", color_at(1)},
    {"alpha", number_at(2, 3) | number_at(3, 3)},
    {"alpha_u", number_at(2, 3)},
    {"alpha_v", number_at(3, 3)},
    {"eta", color_at(2)},
    {"k", color_at(3)},
};
constexpr Place kPrincipledPlaces[] = {
    {"base_color", color_at(0)},     {"metallic", number_at(1, 0)},
    {"diff_trans", number_at(1, 0)}, {"spec_trans", number_at(1, 1)},
    {"spec_tint", number_at(1, 2)},  {"anisotropic", number_at(1, 3)},
    {"eta", number_at(2, 0)},        {"roughness", number_at(2, 1)},
    {"flatness", number_at(2, 2)},   {"clearcoat_gloss", number_at(2, 3)},
    {"sheen", number_at(3, 0)},      {"sheen_tint", number_at(3, 1)},
    {"clearcoat", number_at(3, 2)},
};

constexpr Place kGltfPlaces[] = {
    {"base_color", color_at(0)},
    {"specular_color", color_at(1)},
    {"specular", number_at(1, 3)},
    {"ior", number_at(2, 0)},
    {"roughness", number_at(2, 1)},
    {"metallic", number_at(2, 2)},
    {"anisotropy", number_at(2, 3)},
    {"anisotropy_directions", gpu::kFloatsTurn},
    {"transmission", number_at(3, 0)},
    {"diffuse_transmission", number_at(3, 1)},
    {"clearcoat", number_at(3, 2)},
    {"clearcoat_roughness", number_at(3, 3)},
    {"sheen_color", color_at(4)},
    {"sheen_roughness", number_at(4, 3)},
    {"diffuse_transmission_color", color_at(5)},
    {"iridescence", number_at(5, 3)},
    {"iridescence_ior", number_at(6, 0)},
    {"iridescence_thickness", number_at(6, 1)},
};

template <std::size_t N>
gpu::uint find_place(const Place (&places)[N], std::string_view name) {
  const Place* found = std::ranges::find(places, name, &Place::name);
  if (found == std::end(places))
    throw std::logic_error("'" + std::string(name) + "' has no place in a material's record");
  return found->floats;
}
template <typename T>
gpu::uint floats_of(const T&, std::string_view name) {
  return find_place(kPlaces, name);
}
gpu::uint floats_of(const PrincipledBsdf&, std::string_view name) {
  return find_place(kPrincipledPlaces, name);
}
gpu::uint floats_of(const PrincipledThinBsdf&, std::string_view name) {
  return find_place(kPrincipledPlaces, name);
}

gpu::uint floats_of(const GltfBsdf&, std::string_view name) {
  return find_place(kGltfPlaces, name);
}

gpu::uint texture_of(const ColorParameter& parameter) {
  return *parameter.texture | gpu::kTextureOfColor << gpu::kTextureOfChannelShift;
}
gpu::uint texture_of(const ScalarParameter& parameter) {
  return *parameter.texture | static_cast<gpu::uint>(parameter.channel) << gpu::kTextureOfChannelShift;
}

}  // namespace

gpu::MaterialRecord material_record(const Material& material, std::vector<gpu::vec4>& tables) {
  if (material.adapter) return std::visit([](const auto& adapter) { return flatten(adapter); }, *material.adapter);
  return std::visit(
      [&](const auto& bsdf) {
        if constexpr (requires { flatten(bsdf, tables); })
          return flatten(bsdf, tables);
        else
          return flatten(bsdf);
      },
      material.bsdf);
}

gpu::MaterialTextures material_textures(const Material& material, std::vector<gpu::TextureUse>& uses) {
  gpu::MaterialTextures textures{
      .first = gpu::kNone, .begin = static_cast<gpu::uint>(uses.size()), .end = 0, .coat_normals = gpu::kNone};
  bool first = true;
  each_parameter(material, [&](const char*, const auto& parameter) {
    if (first && parameter.texture) textures.first = texture_of(parameter);
    first = false;
  });
  const auto add = [&](const auto& bsdf) {
    each_parameter(bsdf, [&](const char* name, const auto& parameter) {
      if (!parameter.texture) return;
      if (std::string_view(name) == "coat_normals") {
        textures.coat_normals = texture_of(parameter);
        return;
      }
      const ParameterRange range = parameter_range(bsdf, name);
      uses.push_back({texture_of(parameter), floats_of(bsdf, name), static_cast<float>(range.least),
                      static_cast<float>(range.most)});
    });
  };
  if (!material.adapter) std::visit(add, material.bsdf);
  const auto* gltf = material.adapter ? nullptr : std::get_if<GltfBsdf>(&material.bsdf);
  if (gltf != nullptr && gltf->coat_normals.texture && gltf->coat_vertex_tangents)
    textures.coat_normals |= gpu::kTextureOfVertexTangents;
  textures.end = static_cast<gpu::uint>(uses.size());
  return textures;
}

}  // namespace etendue
