#include "formats/nori/plugins.h"
#include "scene/limits.h"

namespace etendue {
namespace {

using enum ParameterType;

constexpr Range kIndex{1e-3, 1000, false, false};
constexpr Range kUnit{0, 1, false, false};
constexpr Range kRoughness{kMinRoughness, 1, false, false};

Parameter factor(const char* name, const char* default_text, const char* doc) {
  return {name, color, default_text, kUnit, doc, "texture"};
}

Parameter specular_reflectance() {
  return factor("specular_reflectance", "1 1 1", "factor of what is mirrored; other than 1 is not physical");
}

/// A metal: by its name, or by its numbers.
std::vector<Parameter> metal() {
  return {
      {"material", string, "", {}, "a metal by its chemical symbol, as Au, or none, which reflects everything"},
      {"eta", color, "0 0 0", {0, kMaxConductorIndex, false, false}, "real part of the complex index of refraction"},
      {"k", color, "1 1 1", {0, kMaxConductorIndex, false, false}, "its imaginary part, in place of a material"},
      specular_reflectance()};
}

std::vector<Parameter> roughness() {
  return {
      {"distribution", string, "beckmann", {}, "of the microfacets' normals: beckmann or ggx"},
      {"alpha", real, "0.1", kRoughness, "roughness: root mean square slope of the microfacets, times √2", "texture"},
      {"alpha_u", real, "0.1", kRoughness, "roughness along the tangent, in place of alpha", "texture"},
      {"alpha_v", real, "0.1", kRoughness, "roughness across the tangent, in place of alpha", "texture"}};
}

std::vector<Parameter> indices(const char* inside) {
  return {{"intIOR", real, inside, kIndex, "index of refraction inside"},
          {"extIOR", real, "1.000277", kIndex, "index of refraction outside"}};
}

std::vector<Parameter> clear() {
  return {specular_reflectance(),
          factor("specular_transmittance", "1 1 1", "factor of what passes; other than 1 is not physical")};
}

std::vector<Parameter> plastic() {
  return {
      factor("diffuse_reflectance", "0.5 0.5 0.5", "albedo of the base"),
      specular_reflectance(),
      {"nonlinear", boolean, "false", {}, "whether light takes the base's colour at each reflection below the coat"}};
}

/// A probability that may vary over the surface.
Parameter probability(const char* name, const char* doc) {
  return {name, real, "0.5", kUnit, doc, "texture"};
}

/// Rows of what stands around other materials.
std::vector<Plugin> adapter_plugins() {
  return {
      {"bsdf",
       "twosided",
       "The same material on both sides, or one for the front and one for the back, both seen as from their front. "
       "They "
       "must not let light through.",
       {},
       {{"bsdf", 1, 2}}},
      {"bsdf",
       "mask",
       "A material with holes: where it is not opaque, light passes as if there were nothing.",
       {probability("opacity", "share of the light that meets the material")},
       {{"bsdf", 1, 1}}},
      {"bsdf",
       "blend",
       "A mixture of two materials.",
       {probability("weight", "share of the second")},
       {{"bsdf", 2, 2}}},
      {"bsdf",
       "normalmap",
       "A material whose shading normals a picture says: red along dp/du, green across it, blue along the normal, 0 … "
       "1 "
       "for −1 … 1. Pictures of 8 bits want raw.",
       {{"normalmap", color, "0.5 0.5 1", kUnit, "the normals; a texture", "texture"}},
       {{"bsdf", 1, 1}}},
      {"bsdf",
       "bumpmap",
       "A material with the shading normals of a surface that a picture raises.",
       {{"displacement", real, "0", kUnit, "how far; a bitmap", "texture"},
        {"scale", real, "1", {-1e6, 1e6, false, false}, "scene units of 1"}},
       {{"bsdf", 1, 1}}},
      {"bsdf", "null", "No material: light passes as if there were nothing.", {}, {}},
  };
}

Plugin principled_plugin() {
  const auto textured = [](const char* name, const char* default_text, const char* doc) {
    return Parameter{name, real, default_text, kUnit, doc, "texture"};
  };
  return {"bsdf",
          "principled",
          "Burley's material of many parts, as in Mitsuba: metal, plastic, cloth, lacquer, rough glass.",
          {factor("base_color", "0.5 0.5 0.5", "of the diffuse base, of metal, of what is refracted"),
           textured("roughness", "0.5", "its square is the roughness of the microfacets"),
           textured("metallic", "0", "share of metal"),
           textured("anisotropic", "0", "how much longer highlights are along the tangent"),
           textured("spec_trans", "0", "share of the rest that refracts in place of the diffuse base"),
           textured("spec_tint", "0", "how much highlights take the base's colour"),
           textured("sheen", "0", "of cloth, at grazing angles"),
           textured("clearcoat", "0", "weight of a second highlight"),
           {"sheen_tint", real, "0", kUnit, "how much the sheen takes the base's colour"},
           {"flatness", real, "0", kUnit, "of the base: 1 as if light had gone below the surface"},
           {"clearcoat_gloss", real, "0", kUnit, "of the second highlight: 1 is sharp"},
           {"eta", real, "1.5", kIndex, "index of refraction inside over that outside"},
           {"specular", real, "0.5", kUnit, "in place of eta: reflectance along the normal over 0.08"}},
          {}};
}

std::vector<Parameter> joined(std::vector<Parameter> a, const std::vector<Parameter>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

std::vector<Plugin> bsdf_plugins() {
  std::vector<Plugin> rows = {
      {"bsdf",
       "diffuse",
       "Lambertian reflection on the side of the normal; black from behind.",
       {{"albedo",
         color,
         "0.5 0.5 0.5",
         {-1000, 1000, false, false},
         "reflected share of the light; outside 0 … 1 there is a warning",
         "texture"}},
       {}},
      {"bsdf", "mirror", "Perfect reflection on the side of the normal; black from behind.", {}, {}},
      {"bsdf",
       "dielectric",
       "A smooth boundary between two clear media; the normal points to the exterior.",
       {{"intIOR", real, "1.5046", kIndex, "index of refraction inside"},
        {"extIOR", real, "1.000277", kIndex, "index of refraction outside"}},
       {}},
      {"bsdf",
       "microfacet",
       "A diffuse base under a rough dielectric coat of weight 1 − max kd; black from behind.",
       {factor("kd", "0.5 0.5 0.5", "albedo of the base"),
        {"alpha", real, "0.1", kRoughness, "roughness of the coat (Beckmann)", "texture"},
        {"intIOR", real, "1.5046", kIndex, "index of refraction of the coat"},
        {"extIOR", real, "1.000277", kIndex, "index of refraction outside"}},
       {}},
      {"bsdf", "conductor", "A smooth metal; black from behind. The default reflects everything.", metal(), {}},
      {"bsdf", "roughconductor", "A rough metal; black from behind.", joined(metal(), roughness()), {}},
      {"bsdf",
       "roughdielectric",
       "A rough boundary between two clear media; the normal points to the exterior.",
       joined(joined(indices("1.5046"), clear()), roughness()),
       {}},
      {"bsdf", "thindielectric", "A pane of glass without thickness.", joined(indices("1.5046"), clear()), {}},
      {"bsdf",
       "plastic",
       "A diffuse base inside a smooth clear coat; black from behind.",
       joined(indices("1.49"), plastic()),
       {}},
      {"bsdf",
       "roughplastic",
       "A diffuse base inside a rough clear coat; black from behind.",
       joined(joined(indices("1.49"), plastic()),
              {{"distribution", string, "beckmann", {}, "of the microfacets' normals: beckmann or ggx"},
               {"alpha", real, "0.1", kRoughness, "roughness of the coat"}}),
       {}},
  };
  rows.push_back(principled_plugin());
  for (const Plugin& row : adapter_plugins()) rows.push_back(row);
  return rows;
}

}  // namespace etendue
