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
  return {{"material", string, "", {}, "a metal by its chemical symbol, as Au, or none, which reflects everything"},
          {"eta",
           color,
           "0 0 0",
           {0, kMaxConductorIndex, false, false},
           "real part of the complex index of refraction",
           "texture"},
          {"k",
           color,
           "1 1 1",
           {0, kMaxConductorIndex, false, false},
           "its imaginary part, in place of a material",
           "texture"},
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
       {{"normalmap", color, "0.5 0.5 1", kUnit, "the normals; a texture", "texture"},
        {"vertex_tangents", boolean, "false", {}, "along the tangents that the mesh's file has, in place of dp/du"}},
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

Parameter textured(const char* name, const char* default_text, const char* doc, const Range& range = kUnit) {
  return {name, real, default_text, range, doc, "texture"};
}

Plugin principledthin_plugin() {
  return {"bsdf",
          "principledthin",
          "Burley's material of a thin sheet, the same from both sides, as in Mitsuba: paper, leaves, frosted panes.",
          {factor("base_color", "0.5 0.5 0.5", "of the diffuse base and of what passes"),
           textured("roughness", "0.5", "its square is the roughness of the microfacets"),
           textured("anisotropic", "0", "how much longer highlights are along the tangent"),
           textured("spec_trans", "0", "share that is a rough pane in place of the diffuse base"),
           textured("spec_tint", "0", "how much highlights take the base's colour"),
           textured("sheen", "0", "of cloth, at grazing angles"),
           textured("sheen_tint", "0", "how much the sheen takes the base's colour"),
           textured("flatness", "0", "of the base: 1 as if light had gone below the surface"),
           textured("diff_trans", "0", "twice the share of the diffuse base that light passes", {0, 2, false, false}),
           textured("eta", "1.5", "index of refraction inside over that outside", kIndex)},
          {}};
}

Plugin principled_plugin() {
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
           textured("sheen_tint", "0", "how much the sheen takes the base's colour"),
           textured("flatness", "0", "of the base: 1 as if light had gone below the surface"),
           textured("clearcoat_gloss", "0", "of the second highlight: 1 is sharp"),
           textured("eta", "1.5", "index of refraction inside over that outside", kIndex),
           {"specular", real, "0.5", kUnit, "in place of eta: reflectance along the normal over 0.08"}},
          {}};
}

/// A solid's colour and everything else but textures.
std::vector<Parameter> gltf_solid() {
  return {{"thin", boolean, "true", {}, "whether it is a sheet; else the surface of a solid, which bends light"},
          {"attenuation_color", color, "1 1 1", {kMinAttenuation, 1, false, false}, "of white light in a solid"},
          {"attenuation_distance", real, "0", {0, 1e30, false, false}, "after this distance; 0: there is none"},
          {"anisotropy_rotation", real, "0", {-3600, 3600, false, false}, "of the tangent, degrees"}};
}

Plugin gltf_plugin() {
  Plugin row{
      "bsdf",
      "gltf",
      "The material of glTF 2.0 with the extensions of Khronos: metal, plastic, glass, lacquer, velvet, film.",
      {factor("base_color", "1 1 1", "of the diffuse base, of metal, of what passes"),
       textured("metallic", "1", "share of metal"),
       textured("roughness", "1", "its square is the roughness of the microfacets"),
       textured("ior", "1.5", "index of refraction", {1, kMaxTexturedIndex, false, false}),
       textured("specular", "1", "factor of what the boundary reflects"),
       {"specular_color",
        color,
        "1 1 1",
        {0, kMaxSpecularColor, false, false},
        "factor of what it reflects along the normal",
        "texture"},
       textured("transmission", "0", "share that is clear in place of diffuse"),
       textured("diffuse_transmission", "0", "share of the diffuse rest that light passes"),
       factor("diffuse_transmission_color", "1 1 1", "of that light"),
       textured("clearcoat", "0", "weight of a layer of lacquer"),
       textured("clearcoat_roughness", "0", "its square is the roughness of the lacquer"),
       factor("sheen_color", "0 0 0", "of a layer of fibres"),
       textured("sheen_roughness", "0", "its square is the roughness of the fibres"),
       textured("anisotropy", "0", "how much longer highlights are along the tangent"),
       textured("iridescence", "0", "share of a thin film"),
       textured("iridescence_ior", "1.3", "its index of refraction", {1, kMaxFilmIndex, false, false}),
       textured("iridescence_thickness", "400", "its thickness, nanometres", {0, kMaxFilmThickness, false, false})},
      {}};
  row.parameters.push_back({"coat_keeps_normal",
                            boolean,
                            "false",
                            {},
                            "the lacquer has the surface's normal, whatever normal maps do to what lies below it"});
  row.parameters.push_back(
      {"coat_normals", color, "0.5 0.5 1", {0, 1, false, false}, "and is turned by this map; a texture", "texture"});
  row.parameters.push_back(
      {"coat_vertex_tangents", boolean, "false", {}, "along the tangents that the mesh's file has, in place of dp/du"});
  row.parameters.push_back({"dispersion",
                            real,
                            "0",
                            {0, kMaxDispersion, false, false},
                            "of a solid: 20 over its Abbe number, by which red and blue are bent otherwise"});
  for (const Parameter& parameter : gltf_solid()) row.parameters.push_back(parameter);
  return row;
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
       joined(indices("1.5046"), clear()),
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
               {"alpha", real, "0.1", kRoughness, "roughness of the coat", "texture"}}),
       {}},
  };
  rows.push_back(principled_plugin());
  rows.push_back(principledthin_plugin());
  rows.push_back(gltf_plugin());
  for (const Plugin& row : adapter_plugins()) rows.push_back(row);
  return rows;
}

}  // namespace etendue
