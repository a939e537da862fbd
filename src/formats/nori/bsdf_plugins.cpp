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

Parameter flip_invalid_normals() {
  return {"flip_invalid_normals",
          boolean,
          "true",
          {},
          "mirrors turned normals that face away; otherwise nothing is reflected there"};
}
Parameter use_shadowing_function() {
  return {"use_shadowing_function", boolean, "true", {}, "turned normals shadow"};
}

Parameter specular_reflectance() {
  return factor("specular_reflectance", "1 1 1", "factor for reflected light; values other than 1 are not physical");
}

/// A metal: by its name, or by its numbers.
std::vector<Parameter> metal() {
  return {{"material", string, "", {}, "a metal by chemical symbol, such as Au; or none, a perfect mirror"},
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
           "its imaginary part; eta and k replace material",
           "texture"},
          specular_reflectance()};
}

std::vector<Parameter> roughness() {
  return {
      {"distribution", string, "beckmann", {}, "microfacet distribution: beckmann or ggx"},
      {"alpha", real, "0.1", kRoughness, "roughness: root mean square slope of the microfacets, times √2", "texture"},
      {"alpha_u", real, "0.1", kRoughness, "roughness along the tangent, instead of alpha", "texture"},
      {"alpha_v", real, "0.1", kRoughness, "roughness across the tangent, instead of alpha", "texture"}};
}

std::vector<Parameter> indices(const char* inside) {
  return {{"intIOR", real, inside, kIndex, "index of refraction inside"},
          {"extIOR", real, "1.000277", kIndex, "index of refraction outside"}};
}

std::vector<Parameter> clear() {
  return {specular_reflectance(), factor("specular_transmittance", "1 1 1",
                                         "factor for transmitted light; values other than 1 are not physical")};
}

std::vector<Parameter> plastic() {
  return {factor("diffuse_reflectance", "0.5 0.5 0.5", "albedo of the base"),
          specular_reflectance(),
          {"nonlinear",
           boolean,
           "false",
           {},
           "whether light takes on the base's colour at each reflection under the coat"}};
}

/// A probability that may vary over the surface.
Parameter probability(const char* name, const char* doc) {
  return {name, real, "0.5", kUnit, doc, "texture"};
}

/// Materials that contain other materials.
std::vector<Plugin> adapter_plugins() {
  return {
      {"bsdf",
       "twosided",
       "The same material on both sides, or one for the front and one for the back; each is shaded as from its front. "
       "They must be opaque.",
       {},
       {{"bsdf", 1, 2}}},
      {"bsdf",
       "mask",
       "A material with holes, through which light passes unchanged.",
       {probability("opacity", "share of the light that hits the material")},
       {{"bsdf", 1, 1}}},
      {"bsdf",
       "blend",
       "A mixture of two materials.",
       {probability("weight", "share of the second material")},
       {{"bsdf", 2, 2}}},
      {"bsdf",
       "mixture",
       "A mixture of two materials, with the weight of some courses.",
       {probability("weight", "share of the first material")},
       {{"bsdf", 2, 2}}},
      {"bsdf",
       "normalmap",
       "A material with shading normals from a picture: red along dp/du, green across it, blue along the normal, with "
       "0 … 1 meaning −1 … 1. 8-bit pictures need raw.",
       {{"normalmap", color, "0.5 0.5 1", kUnit, "the normals; a texture", "texture"},
        {"vertex_tangents", boolean, "false", {}, "use the tangents in the mesh's file instead of dp/du"},
        flip_invalid_normals(),
        use_shadowing_function()},
       {{"bsdf", 1, 1}}},
      {"bsdf",
       "bumpmap",
       "A material with shading normals as if its surface were displaced by a picture.",
       {{"displacement", real, "0", kUnit, "displacement; a bitmap", "texture"},
        {"scale", real, "1", {-1e6, 1e6, false, false}, "displacement in scene units by the value 1"},
        flip_invalid_normals(),
        use_shadowing_function()},
       {{"bsdf", 1, 1}}},
      {"bsdf", "null", "No material: light passes through unchanged.", {}, {}},
  };
}

Parameter textured(const char* name, const char* default_text, const char* doc, const Range& range = kUnit) {
  return {name, real, default_text, range, doc, "texture"};
}

Plugin principledthin_plugin() {
  return {"bsdf",
          "principledthin",
          "Burley's principled material for thin sheets, the same on both sides, as in Mitsuba: paper, leaves, frosted "
          "panes.",
          {factor("base_color", "0.5 0.5 0.5", "colour of the diffuse base and of transmitted light"),
           textured("roughness", "0.5", "its square is the roughness of the microfacets"),
           textured("anisotropic", "0", "stretches highlights along the tangent"),
           textured("spec_trans", "0", "share of a rough pane instead of the diffuse base"),
           textured("spec_tint", "0", "how far highlights take on the base's colour"),
           textured("sheen", "0", "sheen of cloth, at grazing angles"),
           textured("sheen_tint", "0", "how far the sheen takes on the base's colour"),
           textured("flatness", "0", "flatness of the diffuse base: 1 approximates scattering below the surface"),
           textured("diff_trans", "0", "twice the share of diffuse light that is transmitted", {0, 2, false, false}),
           textured("eta", "1.5", "index of refraction inside over that outside", kIndex)},
          {}};
}

Plugin principled_plugin() {
  return {"bsdf",
          "principled",
          "Burley's principled material, as in Mitsuba: metal, plastic, cloth, lacquer, rough glass.",
          {factor("base_color", "0.5 0.5 0.5", "colour of the diffuse base, of metal and of refracted light"),
           textured("roughness", "0.5", "its square is the roughness of the microfacets"),
           textured("metallic", "0", "share of metal"),
           textured("anisotropic", "0", "stretches highlights along the tangent"),
           textured("spec_trans", "0", "share of the remaining light that is refracted, instead of the diffuse base"),
           textured("spec_tint", "0", "how far highlights take on the base's colour"),
           textured("sheen", "0", "sheen of cloth, at grazing angles"),
           textured("clearcoat", "0", "weight of a second highlight"),
           textured("sheen_tint", "0", "how far the sheen takes on the base's colour"),
           textured("flatness", "0", "flatness of the diffuse base: 1 approximates scattering below the surface"),
           textured("clearcoat_gloss", "0", "gloss of the second highlight: 1 is sharp"),
           textured("eta", "1.5", "index of refraction inside over that outside", kIndex),
           {"specular", real, "0.5", kUnit, "instead of eta: reflectance at normal incidence divided by 0.08"}},
          {}};
}

/// A solid's colour and everything else but textures.
std::vector<Parameter> gltf_solid() {
  return {
      {"thin", boolean, "true", {}, "a thin sheet; if false, the surface of a solid, which bends light"},
      {"attenuation_color",
       color,
       "1 1 1",
       {kMinAttenuation, 1, false, false},
       "colour of white light in a solid after attenuation_distance"},
      {"attenuation_distance", real, "0", {0, 1e30, false, false}, "distance for attenuation_color; 0: no attenuation"},
      {"anisotropy_rotation", real, "0", {-3600, 3600, false, false}, "rotation of the tangent in degrees"}};
}

Plugin gltf_plugin() {
  Plugin row{"bsdf",
             "gltf",
             "The material of glTF 2.0 with the Khronos extensions: metal, plastic, glass, lacquer, velvet, thin film.",
             {factor("base_color", "1 1 1", "colour of the diffuse base, of metal and of transmitted light"),
              textured("metallic", "1", "share of metal"),
              textured("roughness", "1", "its square is the roughness of the microfacets"),
              textured("ior", "1.5", "index of refraction", {1, kMaxTexturedIndex, false, false}),
              textured("specular", "1", "factor for light reflected by the dielectric boundary"),
              {"specular_color",
               color,
               "1 1 1",
               {0, kMaxSpecularColor, false, false},
               "factor for its reflectance at normal incidence",
               "texture"},
              textured("transmission", "0", "share that is clear instead of diffuse"),
              textured("diffuse_transmission", "0", "share of the diffuse rest that is transmitted"),
              factor("diffuse_transmission_color", "1 1 1", "colour of diffusely transmitted light"),
              textured("clearcoat", "0", "weight of a clear coat"),
              textured("clearcoat_roughness", "0", "its square is the roughness of the coat"),
              factor("sheen_color", "0 0 0", "colour of a layer of fibres"),
              textured("sheen_roughness", "0", "its square is the roughness of the fibres"),
              textured("anisotropy", "0", "stretches highlights along the tangent"),
              textured("iridescence", "0", "weight of a thin film"),
              textured("iridescence_ior", "1.3", "index of refraction of the film", {1, kMaxFilmIndex, false, false}),
              textured("iridescence_thickness", "400", "thickness of the film in nanometres",
                       {0, kMaxFilmThickness, false, false})},
             {}};
  row.parameters.push_back({"anisotropy_directions",
                            color,
                            "1 0.5 0.5",
                            {0, 1, false, false},
                            "rotates the tangent by the angle of (2 red − 1, 2 green − 1); a texture",
                            "texture"});
  row.parameters.push_back({"coat_keeps_normal",
                            boolean,
                            "false",
                            {},
                            "the coat keeps the surface's normal, whatever normal maps apply to the base"});
  row.parameters.push_back(
      {"coat_normals", color, "0.5 0.5 1", {0, 1, false, false}, "normal map of the coat; a texture", "texture"});
  row.parameters.push_back(
      {"coat_vertex_tangents", boolean, "false", {}, "use the tangents in the mesh's file instead of dp/du"});
  row.parameters.push_back({"dispersion",
                            real,
                            "0",
                            {0, kMaxDispersion, false, false},
                            "dispersion of a solid: 20 divided by its Abbe number"});
  for (const Parameter& parameter : gltf_solid()) row.parameters.push_back(parameter);
  return row;
}

std::vector<Parameter> joined(std::vector<Parameter> a, const std::vector<Parameter>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

Parameter normals_parameter() {
  return {"normals",
          color,
          "0.5 0.5 1",
          kUnit,
          "shading normals from a picture of plain numbers, without shadowing; for more, use normalmap",
          "texture"};
}

std::vector<Plugin> bsdf_plugins() {
  std::vector<Plugin> rows = {
      {"bsdf",
       "diffuse",
       "Lambertian reflection on the side of the normal; black from behind.",
       {{"albedo",
         color,
         "0.5 0.5 0.5",
         {-1000, 1000, false, false},
         "share of light that is reflected; a warning outside 0 … 1",
         "texture"}},
       {}},
      {"bsdf",
       "mirror",
       "Perfect reflection on the side of the normal; black from behind.",
       {factor("albedo", "1 1 1", "factor for reflected light")},
       {}},
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
      {"bsdf", "conductor", "A smooth metal; black from behind. By default a perfect mirror.", metal(), {}},
      {"bsdf", "roughconductor", "A rough metal; black from behind.", joined(metal(), roughness()), {}},
      {"bsdf",
       "roughdielectric",
       "A rough boundary between two clear media; the normal points to the exterior.",
       joined(joined(indices("1.5046"), clear()), roughness()),
       {}},
      {"bsdf", "thindielectric", "An infinitely thin pane of glass.", joined(indices("1.5046"), clear()), {}},
      {"bsdf",
       "plastic",
       "A diffuse base inside a smooth clear coat; black from behind.",
       joined(indices("1.49"), plastic()),
       {}},
      {"bsdf",
       "roughplastic",
       "A diffuse base inside a rough clear coat; black from behind.",
       joined(joined(indices("1.49"), plastic()),
              {{"distribution", string, "beckmann", {}, "microfacet distribution: beckmann or ggx"},
               {"alpha", real, "0.1", kRoughness, "roughness of the coat", "texture"}}),
       {}},
  };
  rows.push_back(principled_plugin());
  rows.push_back(principledthin_plugin());
  rows.push_back(gltf_plugin());
  for (Plugin& row : rows) {
    row.parameters.push_back(normals_parameter());
    row.parameters.push_back({"opacity", real, "1", kUnit, "share of the light that hits the material", "texture"});
  }
  for (const Plugin& row : adapter_plugins()) rows.push_back(row);
  return rows;
}

}  // namespace etendue
