#include "formats/mitsuba/plugins.h"

#include <iterator>
#include <utility>

#include "formats/mesh_formats.h"
#include "scene/limits.h"

namespace etendue {
namespace {

using enum ParameterType;
using namespace ranges;

Parameter to_world() {
  return {"to_world", transform, "", any(), "object space to world space; the operations apply in the order listed"};
}
Parameter color_or_texture(const char* name, const char* default_text, const char* doc) {
  return {name, color, default_text, at_least(0), doc, "texture"};
}
/// `doc` must begin with "has no effect", by which has_no_effect() recognises such properties.
Parameter no_effect(const char* name, ParameterType type, const char* doc) {
  return {name, type, "", any(), doc};
}

void append(std::vector<Plugin>& rows, std::vector<Plugin> more) {
  rows.insert(rows.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

std::vector<Plugin> scene_rows() {
  return {{"scene",
           "",
           "The root. Bsdfs, textures and groups of shapes at this level are used through `<ref>`; those without a "
           "reference are ignored.",
           {},
           {{"integrator", 0, 1},
            {"sensor", 0, kAnyNumber},
            {"emitter", 0, kAnyNumber},
            {"shape", 0, kAnyNumber},
            {"bsdf", 0, kAnyNumber},
            {"texture", 0, kAnyNumber},
            {"film", 0, kAnyNumber},
            {"sampler", 0, kAnyNumber},
            {"rfilter", 0, kAnyNumber}}}};
}

/// Adds parameters of Mitsuba's integrators that affect scheduling but not light.
std::vector<Parameter> scheduled(std::vector<Parameter> own) {
  own.insert(own.end(), {no_effect("samples_per_pass", integer, "has no effect: the device decides"),
                         no_effect("block_size", integer, "has no effect: the device decides"),
                         no_effect("timeout", real, "has no effect: use --time"),
                         no_effect("strict_normals", boolean, "has no effect: shading normals decide (0.6)")});
  return own;
}

std::vector<Parameter> path_parameters() {
  return scheduled(
      {{"max_depth", integer, "-1", between(-1, 1 << 30), "path segments: 1 is emitted light only; -1 is no limit"},
       {"rr_depth", integer, "5", between(1, 1 << 30), "Russian roulette from this segment on"},
       {"hide_emitters", boolean, "false", any(), "hides emitters from camera rays"}});
}

Plugin as_path(const char* type) {
  return {"integrator", type, "Read as `path`, which computes the same light.", path_parameters(), {}};
}

std::vector<Plugin> integrator_rows() {
  std::vector<Plugin> rows = {
      {"integrator",
       "path",
       "Path tracing with multiple importance sampling. The default if a scene has no integrator.",
       path_parameters(),
       {}},
      {"integrator",
       "direct",
       "Light that arrives after at most one reflection.",
       scheduled({{"shading_samples", integer, "1", between(0, kMaxDirectSamples), "sets both of the next two"},
                  {"emitter_samples", integer, "1", between(0, kMaxDirectSamples), "samples of lights"},
                  {"bsdf_samples", integer, "1", between(0, kMaxDirectSamples), "samples of materials"},
                  {"hide_emitters", boolean, "false", any(), "hides emitters from camera rays"}}),
       {}},
      {"integrator",
       "depth",
       "Distance along the ray from the near clipping plane to the first surface; 0 if there is none.",
       scheduled({}),
       {}},
      {"integrator",
       "moment",
       "Renders its child; every EXR file contains the standard error anyway.",
       scheduled({}),
       {{"integrator", 1, 1}}},
      {"integrator",
       "aov",
       "Renders its child and the AOVs listed in `aovs`. Depth is the distance from the camera itself; in Mitsuba it "
       "starts at the near clipping plane.",
       scheduled(
           {{"aovs", string, nullptr, any(),
             "comma-separated pairs of a name of your own, which is not kept, and one of `depth`, `position`, `uv`, "
             "`geo_normal`, `sh_normal`, `prim_index`, `shape_index`, `albedo`: `d:depth,n:sh_normal`"}}),
       {{"integrator", 0, 1}}},
  };
  rows.push_back(
      {"integrator",
       "ao",
       "The unoccluded share of the hemisphere, weighted by the cosine (Mitsuba 0.6).",
       {{"ray_length", real, "-1", any(), "how far to look for occluders; -1 is a quarter of the scene's diagonal"},
        no_effect("shading_samples", integer, "has no effect: one sample per camera ray")},
       {}});
  for (const char* type :
       {"ptracer", "bdpt", "mlt", "pssmlt", "erpt", "photonmapper", "ppm", "sppm", "prb", "prb_basic", "prb_projective",
        "direct_projective", "adjoint_path", "irrcache", "volpath", "volpathmis", "volpath_simple", "prbvolpath"})
    rows.push_back(as_path(type));
  return rows;
}

std::vector<Parameter> sensor_parameters(std::vector<Parameter> own) {
  own.insert(own.end(), {{"near_clip", real, "0.01", at_least(0), "nearest visible distance along the camera's +z"},
                         {"far_clip", real, "10000", above(0), "farthest visible distance along the camera's +z"},
                         no_effect("shutter_open", real, "has no effect: nothing moves"),
                         no_effect("shutter_close", real, "has no effect: nothing moves"),
                         {"jitter", boolean, "true", any(),
                          "rays spread over their pixels; false is not supported, left out with --approximate"},
                         no_effect("cone_scale", real, "has no effect: many samples filter pictures"),
                         {"srf", color, "1 1 1", any(), "spectral response; not supported, left out with --approximate",
                          "texture"},
                         to_world()});
  return own;
}

std::vector<Parameter> field_of_view() {
  return {{"fov", real, "", inside(0, 180), "field of view in degrees along fov_axis"},
          {"focal_length", string, "50mm", any(), "focal length for 36 × 24 mm film, instead of fov"},
          {"fov_axis", string, "x", any(), "x, y, diagonal, smaller or larger"},
          {"principal_point_offset_x", real, "0", between(-1000, 1000), "shifts the picture, in widths of the film"},
          {"principal_point_offset_y", real, "0", between(-1000, 1000), "shifts the picture, in heights of the film"}};
}

std::vector<Plugin> sensor_rows() {
  const std::vector<ChildRule> children = {{"film", 0, 1}, {"sampler", 0, 1}};
  std::vector<Parameter> pinhole = field_of_view(), lens = field_of_view();
  pinhole.push_back(no_effect("focus_distance", real, "has no effect: a pinhole has no focus"));
  lens.insert(lens.end(),
              {{"aperture_radius", real, nullptr, at_least(0), "radius of the lens, in units of the camera"},
               {"focus_distance", real, "", above(0), "distance that is in focus; by default far_clip"}});
  const auto ignored = [](const char* name) { return no_effect(name, real, "has no effect"); };
  return {
      {"sensor", "perspective", "A pinhole camera: +z forward, +y up, +x to the left of the image.",
       sensor_parameters(std::move(pinhole)), children},
      {"sensor", "thinlens", "A perspective camera with a thin lens.", sensor_parameters(std::move(lens)), children},
      {"sensor", "orthographic", "Parallel rays; the film is 2 camera units wide.",
       sensor_parameters({ignored("focus_distance")}), children},
      {"sensor", "spherical", "All directions: longitude across, polar angle down (Mitsuba 0.6).",
       sensor_parameters({ignored("focus_distance")}), children},
      {"sensor", "radiancemeter", "One ray along the camera's +z.",
       sensor_parameters({{"origin", point, "0 0 0", any(), "where the ray starts, instead of to_world"},
                          {"direction", vector, "0 0 1", any(), "direction of the ray, instead of to_world"}}),
       children},
      {"sensor",
       "batch",
       "Sensors side by side in one film. Not supported: the scene is refused; with --approximate the first sensor is "
       "rendered, with its share of the film.",
       {},
       {{"sensor", 1, kAnyNumber}, {"film", 0, 1}, {"sampler", 0, 1}}},
      {"sensor",
       "distant",
       "The mean radiance seen along one direction, on a film of one pixel. The rays are aimed at a point, at a "
       "rectangle or disk (a child `<shape>`), or uniformly at the whole scene: at the cross-section of the sphere "
       "around the box of its shapes. They start two radii of that sphere before their target.",
       {{"direction", vector, "0 0 1", any(), "direction of the rays, instead of the +z of to_world"},
        {"target", point, "", any(), "the point that the rays are aimed at"},
        ignored("shutter_open"),
        ignored("shutter_close"),
        to_world()},
       {{"film", 0, 1}, {"sampler", 0, 1}, {"shape", 0, 1}}},
      {"sensor",
       "irradiancemeter",
       "The irradiance of its parent rectangle, on the side of the normal; the film covers the rectangle.",
       {ignored("shutter_open"), ignored("shutter_close")},
       children},
  };
}

Plugin film_row(const char* type) {
  return {"film",
          type,
          "Size and filter of the image. The command line determines which files are written.",
          {{"width", integer, "768", between(1, 65536), "pixels"},
           {"height", integer, "576", between(1, 65536), "pixels"},
           {"crop_offset_x", integer, "0", between(0, 65536), "first rendered column"},
           {"crop_offset_y", integer, "0", between(0, 65536), "first rendered row"},
           {"crop_width", integer, "0", between(1, 65536), "number of rendered columns; by default all remaining ones"},
           {"crop_height", integer, "0", between(1, 65536), "number of rendered rows; by default all remaining ones"},
           no_effect("pixel_format", string, "has no effect: files hold RGB"),
           no_effect("component_format", string, "has no effect: outputs have fixed formats"),
           no_effect("file_format", string, "has no effect: the output's file name decides"),
           no_effect("sample_border", boolean, "has no effect: filters are sampled"),
           no_effect("compensate", boolean, "has no effect: sums are exact"),
           no_effect("banner", boolean, "has no effect"),
           no_effect("high_quality_edges", boolean, "has no effect: filters are sampled"),
           no_effect("attach_log", boolean, "has no effect"),
           no_effect("gamma", real, "has no effect: EXR files are linear, PNG files sRGB"),
           no_effect("exposure", real, "has no effect: EXR files are linear"),
           no_effect("fov_axis", string, "has no effect here")},
          {{"rfilter", 0, 1}}};
}

std::vector<Plugin> view_rows() {
  std::vector<Plugin> rows = sensor_rows();
  for (const char* type : {"hdrfilm", "ldrfilm"}) rows.push_back(film_row(type));
  const auto sampler = [](const char* type, const char* doc) {
    return Plugin{"sampler",
                  type,
                  doc,
                  {{"sample_count", integer, "4", between(1, 4294967295.0), "samples per pixel"},
                   no_effect("seed", integer, "has no effect: use --seed"),
                   no_effect("jitter", boolean, "has no effect"),
                   no_effect("scramble", integer, "has no effect: points are always scrambled"),
                   no_effect("strength", integer, "has no effect"),
                   no_effect("dimension", integer, "has no effect")},
                  {}};
  };
  rows.push_back(sampler("independent", "Independent random numbers."));
  for (const char* type :
       {"stratified", "multijitter", "orthogonal", "bose", "bush", "ldsampler", "sobol", "halton", "hammersley"})
    rows.push_back(sampler(type, "Read as `sobol`: scrambled Sobol points in independent sets of 16."));
  append(rows, {
                   {"rfilter",
                    "box",
                    "The pixel's square, or a larger one (0.6).",
                    {{"radius", real, "0.5", above_up_to(0, 32), "pixels"}},
                    {}},
                   {"rfilter", "tent", "A tent.", {{"radius", real, "1", above_up_to(0, 32), "pixels"}}, {}},
                   {"rfilter",
                    "gaussian",
                    "A Gaussian with a radius of 4 standard deviations, lowered to reach zero there; the default "
                    "filter of a film.",
                    {{"stddev", real, "0.5", above(0), "standard deviation in pixels"}},
                    {}},
                   {"rfilter",
                    "mitchell",
                    "The filter of Mitchell and Netravali.",
                    {{"A", real, "0.3333333333333333", any(), "blur, also called B"},
                     {"B", real, "0.3333333333333333", any(), "ringing, also called C, or blur where C is given"},
                     {"C", real, "0.3333333333333333", any(), "ringing"}},
                    {}},
                   {"rfilter", "catmullrom", "The filter of Mitchell and Netravali with B = 0 and C = 1/2.", {}, {}},
                   {"rfilter",
                    "lanczos",
                    "A windowed sinc function; every second lobe is negative.",
                    {{"lobes", integer, "3", between(1, kMaxFilterLobes), "radius in pixels"}},
                    {}},
               });
  return rows;
}

std::vector<ChildRule> surface() {
  return {{"bsdf", 0, 1}, {"emitter", 0, 1}, {"sensor", 0, 1}};
}

Parameter flip_normals() {
  return {"flip_normals", boolean, "false", any(), "turns the surface inside out"};
}
Parameter face_normals() {
  return {"face_normals", boolean, "false", any(), "flat triangles, even if the file has normals"};
}

Parameter mesh_file() {
  return {"filename", string, nullptr, any(),
          "the file; searched for in the folders of <path>, then in that of the scene"};
}

std::vector<Plugin> mesh_file_rows() {
  std::vector<Plugin> rows;
  for (const MeshFormat& format : mesh_formats()) {
    const bool flips = std::string_view(format.word) == "obj";
    rows.push_back(
        {"shape",
         format.word,
         format.doc,
         {mesh_file(),
          face_normals(),
          flip_normals(),
          {"flip_tex_coords", boolean, flips ? "true" : "false", any(), "whether v grows upward in the file"},
          no_effect("collapse", boolean, "has no effect: the file is read as one mesh"),
          no_effect("max_smooth_angle", real, "has no effect"),
          no_effect("srgb", boolean, "has no effect"),
          to_world()},
         surface()});
  }
  rows.push_back({"shape",
                  "serialized",
                  "Triangles from a file in Mitsuba's own format.",
                  {mesh_file(),
                   {"shape_index", integer, "0", between(0, 4294967295.0), "index of the mesh in the file"},
                   face_normals(),
                   flip_normals(),
                   no_effect("max_smooth_angle", real, "has no effect"),
                   to_world()},
                  surface()});
  return rows;
}

std::vector<Plugin> shape_rows() {
  return {
      {"shape",
       "sphere",
       "An exact sphere.",
       {{"center", point, "0 0 0", any(), "object space"},
        {"radius", real, "1", above(0), "object space"},
        flip_normals(),
        to_world()},
       surface()},
      {"shape",
       "rectangle",
       "From -1 to 1 in x and y, at z = 0; the normal is +z.",
       {flip_normals(), to_world()},
       surface()},
      {"shape", "cube", "From -1 to 1 in x, y and z.", {flip_normals(), to_world()}, surface()},
      {"shape",
       "disk",
       "x² + y² ≤ 1 at z = 0; the normal is +z. Texture coordinates are the distance from the centre and the "
       "angle.",
       {flip_normals(), to_world()},
       surface()},
      {"shape",
       "cylinder",
       "The side of a cylinder, open at both ends. Texture coordinates are the angle and the position from p0 "
       "to p1.",
       {{"p0", point, "0 0 0", any(), "one end of the axis"},
        {"p1", point, "0 0 1", any(), "the other end"},
        {"radius", real, "1", above(0), "object space"},
        flip_normals(),
        to_world()},
       surface()},
      {"shape", "merge", "Its shapes, as if they were children of the scene.", {}, {{"shape", 0, kAnyNumber}}},
      {"shape", "shapegroup", "Shapes that appear wherever an `instance` shows them.", {}, {{"shape", 0, kAnyNumber}}},
      {"shape", "instance", "A copy of a group of shapes.", {to_world()}, {{"shape", 1, 1}}},
  };
}

std::vector<Parameter> metal_parameters() {
  return {{"material", string, "none", any(), "the name of a metal; none is a perfect mirror"},
          color_or_texture("eta", "0 0 0", "real part of the index of refraction"),
          color_or_texture("k", "1 1 1", "imaginary part of the index of refraction"),
          {"ext_eta", real, "vacuum", between(1e-3, 1000), "index of refraction outside; eta and k are divided by it"},
          color_or_texture("specular_reflectance", "1 1 1", "factor for reflected light")};
}

std::vector<Parameter> joined(std::vector<Parameter> a, const std::vector<Parameter>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Parameter number_or_texture(const char* name, const char* default_text, const Range& range, const char* doc) {
  return {name, real, default_text, range, doc, "texture"};
}

std::vector<Parameter> distribution() {
  return {{"distribution", string, "beckmann", any(), "microfacet distribution: beckmann or ggx"},
          no_effect("sample_visible", boolean, "has no effect: visible facets are sampled")};
}
Parameter alpha(const char* name, const char* doc) {
  return number_or_texture(name, "0.1", between(0, 2), doc);
}
std::vector<Parameter> roughness() {
  return joined(distribution(),
                {alpha("alpha", "roughness"), alpha("alpha_u", "roughness along the tangent, instead of alpha"),
                 alpha("alpha_v", "roughness across it")});
}

std::vector<Parameter> indices(const char* inside) {
  return {{"int_ior", real, inside, between(1e-3, 1000), "index of refraction inside, a number or a name"},
          {"ext_ior", real, "air", between(1e-3, 1000), "index of refraction outside, a number or a name"}};
}
std::vector<Parameter> clear() {
  return joined(indices("bk7"), {color_or_texture("specular_reflectance", "1 1 1", "factor for reflected light"),
                                 color_or_texture("specular_transmittance", "1 1 1", "factor for transmitted light")});
}
std::vector<Parameter> plastic() {
  return joined(indices("polypropylene"),
                {color_or_texture("diffuse_reflectance", "0.5 0.5 0.5", "albedo of the base"),
                 color_or_texture("specular_reflectance", "1 1 1", "factor for light reflected by the coat"),
                 {"nonlinear", boolean, "false", any(),
                  "whether light takes on the base's colour at each reflection under the coat"}});
}

/// The parameters that principled and principledthin share.
std::vector<Parameter> principled_base() {
  const auto share = [&](const char* name, const char* default_text, const char* doc) {
    return number_or_texture(name, default_text, between(0, 1), doc);
  };
  return {
      color_or_texture("base_color", "0.5 0.5 0.5", "colour of the diffuse base, of metal and of transmitted light"),
      number_or_texture("eta", "1.5", between(1e-3, 1000), "index of refraction, a number or a name"),
      share("roughness", "0.5", "its square is the roughness of the microfacets"),
      share("anisotropic", "0", "stretches highlights along the tangent"),
      share("spec_trans", "0", "share of the remaining light that is refracted"),
      share("spec_tint", "0", "how far highlights take on the base's colour"),
      share("sheen", "0", "sheen of cloth, at grazing angles"),
      share("sheen_tint", "0", "how far the sheen takes on the base's colour"),
      share("flatness", "0", "flatness of the diffuse base"),
      no_effect("diffuse_reflectance_sampling_rate", real, "has no effect: lobes are sampled by their weights")};
}

std::vector<Parameter> principled() {
  return joined(
      principled_base(),
      {{"specular", real, "0.5", between(0, 1), "instead of eta: reflectance at normal incidence divided by 0.08"},
       number_or_texture("metallic", "0", between(0, 1), "share of metal"),
       number_or_texture("clearcoat", "0", between(0, 1), "weight of a second highlight"),
       number_or_texture("clearcoat_gloss", "0", between(0, 1), "gloss of the second highlight"),
       no_effect("main_specular_sampling_rate", real, "has no effect: lobes are sampled by their weights"),
       no_effect("clearcoat_sampling_rate", real, "has no effect: lobes are sampled by their weights")});
}

std::vector<Parameter> principledthin() {
  std::vector<Parameter> parameters = joined(
      principled_base(),
      {number_or_texture("diff_trans", "0", between(0, 2), "twice the share of diffuse light that is transmitted")});
  for (const char* lobe : {"specular_reflectance_sampling_rate", "specular_transmittance_sampling_rate",
                           "diffuse_transmittance_sampling_rate"})
    parameters.push_back(no_effect(lobe, real, "has no effect: lobes are sampled by their weights"));
  return parameters;
}

std::vector<Parameter> map_parameters(const Parameter& own) {
  return {own,
          {"flip_invalid_normals", boolean, "true", any(),
           "mirrors turned normals that face away; otherwise nothing is reflected there"},
          {"use_shadowing_function", boolean, "true", any(), "turned normals shadow"}};
}

/// Mixtures, and unsupported materials that have a substitute.
std::vector<Plugin> other_bsdf_rows() {
  const std::vector<Parameter> lobe = {color_or_texture("specular_reflectance", "0.2 0.2 0.2", "weight of the lobe"),
                                       color_or_texture("diffuse_reflectance", "0.5 0.5 0.5", "albedo of the base")};
  const std::vector<Parameter> coat = joined(
      indices("bk7"), {{"thickness", real, "1", at_least(0), "thickness of the coat"},
                       color_or_texture("sigma_a", "0 0 0", "what the coat absorbs"),
                       color_or_texture("specular_reflectance", "1 1 1", "factor for light reflected by the coat")});
  const char* coated =
      "A material under a clear coat (0.6). Not supported: the scene is refused, or with --approximate rendered "
      "without the coat.";
  return {
      {"bsdf",
       "phong",
       "A diffuse base and a lobe around the mirror direction (0.6). Not supported: the scene is refused, or with "
       "--approximate the lobe becomes that of a rough Beckmann mirror of roughness √(2/(exponent + 2)).",
       joined({{"exponent", real, "30", at_least(0), "exponent of the cosine"}}, lobe),
       {}},
      {"bsdf",
       "ward",
       "A diffuse base and Ward's lobe (0.6). Not supported: the scene is refused, or with --approximate the lobe "
       "becomes that of a rough Beckmann mirror of the same roughness.",
       joined({{"variant", string, "balanced", any(), "ward, ward-duer or balanced"},
               {"alpha_u", real, "0.1", at_least(0), "roughness along the tangent"},
               {"alpha_v", real, "0.1", at_least(0), "roughness across it"}},
              lobe),
       {}},
      {"bsdf", "coating", coated, coat, {{"bsdf", 1, 1}}},
      {"bsdf",
       "roughcoating",
       coated,
       joined(coat, joined(distribution(), {alpha("alpha", "roughness of the coat")})),
       {{"bsdf", 1, 1}}},
      {"bsdf",
       "pplastic",
       "A plastic that polarizes. Not supported: the scene is refused, or with --approximate it becomes "
       "`roughplastic`.",
       joined(joined(plastic(), distribution()), {alpha("alpha", "roughness of the coat")}),
       {}},
      {"bsdf",
       "roughdiffuse",
       "Diffuse reflection by rough ground (0.6). Not supported: the scene is refused, or with --approximate it "
       "becomes "
       "`diffuse`.",
       {color_or_texture("reflectance", "0.5 0.5 0.5", "share of light that is reflected"),
        color_or_texture("diffuse_reflectance", "0.5 0.5 0.5", "another name for reflectance"),
        number_or_texture("alpha", "0.2", at_least(0), "roughness"),
        {"use_fast_approx", boolean, "false", any(), "a simpler formula"}},
       {}},
      {"bsdf",
       "mixturebsdf",
       "A mixture of any number of materials (0.6). If the weights add up to less than 1, the rest is black; if to "
       "more, they are scaled.",
       {{"weights", number_list, nullptr, at_least(0), "one for each material"}},
       {{"bsdf", 1, kAnyNumber}}},
  };
}

std::vector<Plugin> bsdf_rows() {
  return {
      {"bsdf",
       "diffuse",
       "Lambertian reflection on the side of the normal. Shapes without a bsdf have this one, or a black one if they "
       "emit.",
       {color_or_texture("reflectance", "0.5 0.5 0.5", "share of light that is reflected"),
        color_or_texture("diffuse_reflectance", "0.5 0.5 0.5", "another name for reflectance")},
       {}},
      {"bsdf",
       "dielectric",
       "A smooth boundary between two clear media; the normal points to the exterior.",
       clear(),
       {}},
      {"bsdf", "thindielectric", "An infinitely thin pane of glass.", clear(), {}},
      {"bsdf", "roughdielectric", "A rough boundary between two clear media.", joined(clear(), roughness()), {}},
      {"bsdf",
       "conductor",
       "A smooth metal, visible from the side of the normal. In scenes for 0.6 the default is copper in air.",
       metal_parameters(),
       {}},
      {"bsdf",
       "roughconductor",
       "A metal with a rough microfacet surface.",
       joined(metal_parameters(), roughness()),
       {}},
      {"bsdf", "plastic", "A diffuse base inside a smooth clear coat.", plastic(), {}},
      {"bsdf",
       "roughplastic",
       "A diffuse base inside a rough clear coat.",
       joined(joined(plastic(), distribution()), {alpha("alpha", "roughness of the coat")}),
       {}},
      {"bsdf",
       "twosided",
       "A material for both sides, or one for the front and one for the back.",
       {},
       {{"bsdf", 1, 2}}},
      {"bsdf",
       "mask",
       "A material with holes.",
       {{"opacity", real, "0.5", between(0, 1), "share of the light that hits the material", "texture"}},
       {{"bsdf", 1, 1}}},
      {"bsdf",
       "blendbsdf",
       "A mixture of two materials.",
       {{"weight", real, "0.5", between(0, 1), "share of the second material", "texture"}},
       {{"bsdf", 2, 2}}},
      {"bsdf",
       "normalmap",
       "A material with shading normals from a picture.",
       map_parameters(color_or_texture("normalmap", "0.5 0.5 1", "the normals; a raw texture (in 0.6 with any name)")),
       {{"bsdf", 1, 1}, {"texture", 0, 1}}},
      {"bsdf",
       "bumpmap",
       "A material with shading normals as if its surface were displaced by a picture. The texture may have any name.",
       map_parameters({"scale", real, "1", any(), "displacement in scene units by the value 1"}),
       {{"bsdf", 1, 1}, {"texture", 1, 1}}},
      {"bsdf", "principled", "Burley's principled material.", principled(), {}},
      {"bsdf", "principledthin", "Burley's principled material for thin sheets.", principledthin(), {}},
      {"bsdf", "null", "No material: light passes through.", {}, {}},
  };
}

Parameter texture_transform() {
  return {"to_uv", transform, "", any(),
          "from texture coordinates of the surface to those of the texture; z is not used"};
}
std::vector<Parameter> old_texture_transform() {
  const auto number = [](const char* name, const char* default_text, const char* doc) {
    return Parameter{name, real, default_text, between(-1e9, 1e9), doc};
  };
  return {texture_transform(),
          number("uvscale", "1", "factor for u and v (0.6)"),
          number("uscale", "1", "factor for u, instead of uvscale (0.6)"),
          number("vscale", "1", "factor for v, instead of uvscale (0.6)"),
          number("uoffset", "0", "added to u after that (0.6)"),
          number("voffset", "0", "added to v after that (0.6)")};
}

std::vector<Plugin> texture_rows() {
  const auto wrap = [](const char* name, const char* doc) { return Parameter{name, string, "repeat", any(), doc}; };
  return {
      {"texture",
       "bitmap",
       "A picture: PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR. Its first row is at v = 0.",
       joined({{"filename", string, nullptr, any(),
                "the file; searched for in the folders of <path>, then in that of the scene"},
               {"raw", boolean, "false", any(), "8-bit values are plain numbers, not sRGB-encoded colours"},
               {"gamma", real, "-1", any(), "1 is the same as raw (0.6); with -1 the file type decides"},
               {"filter_type", string, "bilinear", any(), "between texels: bilinear or nearest"},
               wrap("wrap_mode", "beyond the edges: repeat, mirror or clamp, in 0.6 also zero or one"),
               wrap("wrap_mode_u", "along u (0.6)"),
               wrap("wrap_mode_v", "along v (0.6)"),
               {"channel", string, "", any(),
                "the channel to use as a number (0.6): r, g, b, a or y; by default luminance"},
               no_effect("format", string, "has no effect: texels are kept as they are stored"),
               no_effect("accel", boolean, "has no effect"),
               no_effect("cache", boolean, "has no effect"),
               no_effect("max_anisotropy", real, "has no effect")},
              old_texture_transform()),
       {}},
      {"texture",
       "checkerboard",
       "Squares of side 1/2 in texture coordinates.",
       joined({color_or_texture("color0", "0.4 0.4 0.4",
                                "colour of the square at (0,0) and of those that touch it at a corner"),
               color_or_texture("color1", "0.2 0.2 0.2", "colour of the others")},
              old_texture_transform()),
       {}},
      {"texture",
       "mesh_attribute",
       "Colours or numbers stored in the mesh's file.",
       {{"name", string, nullptr, any(),
         "vertex_NAME, which is interpolated, or face_NAME: in PLY files the properties NAME_0 to NAME_2, or NAME_0"},
        {"scale", real, "1", any(), "a factor"}},
       {}},
      {"texture", "vertexcolors", "Interpolated colours of a mesh's vertices (0.6).", {}, {}},
      {"texture", "rawconstant", "One number or three.", {color_or_texture("value", "0 0 0", "the value")}, {}},
      {"texture",
       "scale",
       "Another texture times a factor (0.6).",
       {color_or_texture("scale", "1 1 1", "the factor")},
       {{"texture", 1, 1}}},
  };
}

std::vector<Plugin> emitter_rows() {
  return {
      {"emitter",
       "area",
       "Makes its shape a light that emits on the side of the shading normal.",
       {color_or_texture("radiance", "1 1 1", "emitted radiance, the same in all directions"),
        no_effect("sampling_weight", real, "has no effect: lights are chosen by their contribution")},
       {}},
      {"emitter",
       "constant",
       "Uniform light from all directions.",
       {color_or_texture("radiance", "1 1 1", "radiance from all directions"),
        no_effect("sampling_weight", real, "has no effect: lights are chosen by their contribution"), to_world()},
       {}},
      {"emitter",
       "envmap",
       "Light from all directions, given by a latitude-longitude picture, +y up; its first and last rows are the "
       "poles.",
       {{"filename", string, "", any(),
         "the file; searched for in the folders of <path>, then in that of the scene; or given by a child texture "
         "`bitmap`"},
        {"scale", real, "1", between(0, 1e20), "a factor"},
        no_effect("sampling_weight", real, "has no effect: lights are chosen by their contribution"),
        no_effect("mis_compensation", boolean, "has no effect"),
        no_effect("cache", boolean, "has no effect"),
        to_world()},
       {{"texture", 0, 1}}},
  };
}

std::vector<Plugin> delta_light_rows() {
  const auto weight = [] {
    return no_effect("sampling_weight", real, "has no effect: lights are chosen by their contribution");
  };
  return {
      {"emitter",
       "point",
       "A point that emits equally in all directions. Reached only by sampling lights.",
       {{"position", point, "0 0 0", any(), "position"},
        color_or_texture("intensity", "1 1 1", "power per solid angle"),
        weight(),
        to_world()},
       {}},
      {"emitter",
       "spot",
       "A point that emits into a cone about +z, fading linearly with the angle between beam_width and cutoff_angle.",
       {color_or_texture("intensity", "1 1 1", "power per solid angle along its axis"),
        {"cutoff_angle", real, "20", inside(0, 180), "half angle of the cone in degrees"},
        {"beam_width", real, "", between(0, 180),
         "half angle of full intensity in degrees; by default 3/4 of cutoff_angle"},
        {"texture", object, "", any(), "a picture projected across the cone", "texture"},
        weight(),
        to_world()},
       {}},
      {"emitter",
       "projector",
       "A camera in reverse: projects a picture from the origin along +z.",
       {color_or_texture("irradiance", "1 1 1",
                         "irradiance of the plane z = 1 divided by π: the radiance of a white surface there"),
        {"scale", real, "1", at_least(0), "factor of the irradiance"},
        {"fov", real, "40", inside(0, 180), "field of view in degrees along fov_axis"},
        {"fov_axis", string, "x", any(), "x, y, smaller or larger"},
        weight(),
        to_world()},
       {}},
      {"emitter",
       "directional",
       "Parallel light from infinitely far away, along `direction` or the +z of to_world.",
       {{"direction", vector, "0 0 1", any(), "direction in which the light travels"},
        color_or_texture("irradiance", "1 1 1", "irradiance of a surface that faces it"),
        weight(),
        to_world()},
       {}},
  };
}

/// Has the parameters of both Mitsuba 0.6 and 3.
std::vector<Plugin> daylight_rows() {
  const std::vector<Parameter> parameters = {
      {"turbidity", real, "3", between(1, 10), "how hazy the air is"},
      {"sun_direction", vector, "", any(), "toward the sun, before to_world; the default follows from place and time:"},
      {"latitude", real, "35.6894", between(-90, 90), "degrees north"},
      {"longitude", real, "139.6917", between(-180, 180), "degrees east"},
      {"timezone", real, "9", between(-14, 14), "hours ahead of universal time"},
      no_effect("year", integer, "has no effect: the sun's position changes by less than half a degree between years"),
      {"month", integer, "7", between(1, 12), "of the year"},
      {"day", integer, "10", between(1, 31), "of the month"},
      {"hour", real, "15", between(0, 24), "local time"},
      {"minute", real, "0", between(0, 60), "local time"},
      {"second", real, "0", between(0, 60), "local time"},
      {"scale", real, "1", at_least(0), "factor of sky and sun"},
      {"sky_scale", real, "1", at_least(0), "factor of the sky's radiance"},
      {"sun_scale", real, "1", at_least(0), "factor of the sun's radiance"},
      {"sun_aperture", real, "", between(0, 60), "apparent diameter of the sun in degrees"},
      {"sun_radius_scale", real, "1", between(0, 60), "apparent diameter relative to the real sun's"},
      {"albedo", color, "", at_least(0), "has no effect: Preetham's sky has no ground", "texture"},
      no_effect("complex_sun", boolean, "has no effect: the sun's disk is uniform"),
      no_effect("stretch", real, "has no effect"),
      no_effect("resolution", integer, "has no effect: the sky picture is always 1024 pixels wide"),
      no_effect("sampling_weight", real, "has no effect"),
      to_world()};
  const char* doc =
      "Daylight. Mitsuba's models need tables of coefficients that Etendue does not have: the scene is refused, or "
      "with --approximate gets Preetham's sky with the same sun and turbidity.";
  std::vector<Plugin> rows;
  for (const char* type : {"sky", "sun", "sunsky"}) rows.push_back({"emitter", type, doc, parameters, {}});
  return rows;
}

std::vector<Plugin> make_rows() {
  std::vector<Plugin> rows = scene_rows();
  append(rows, integrator_rows());
  append(rows, view_rows());
  append(rows, mesh_file_rows());
  append(rows, shape_rows());
  for (Plugin& row : rows) {
    if (row.tag == std::string_view("shape") && row.find("to_world") != nullptr && row.find_child("bsdf") != nullptr)
      row.parameters.push_back(
          no_effect("silhouette_sampling_weight", real, "has no effect: nothing is differentiated"));
  }
  append(rows, bsdf_rows());
  append(rows, other_bsdf_rows());
  append(rows, emitter_rows());
  append(rows, texture_rows());
  append(rows, delta_light_rows());
  append(rows, daylight_rows());
  return rows;
}

std::vector<UnsupportedTypes> unsupported_types() {
  return {
      {"integrator", {"stokes", "vpl", "multichannel", "adaptive"}},
      {"sensor", {"telecentric", "fluencemeter", "perspective_rdist"}},
      {"film", {"specfilm", "mfilm", "tiledhdrfilm"}},
      {"rfilter", {"spline"}},
      {"shape",
       {"heightfield", "hair", "deformable", "linearcurve", "bsplinecurve", "sdfgrid", "ellipsoids", "ellipsoidsmesh"}},
      {"bsdf",
       {"measured", "hair", "difftrans", "hk", "polarizer", "retarder", "circular", "measured_polarized", "irawan"}},
      {"emitter", {"directionalarea", "collimated", "timed_sunsky", "volumelight"}},
      {"texture", {"volume", "gridtexture", "wireframe", "curvature"}},
  };
}

}  // namespace

const Dialect& mitsuba_dialect() {
  static const Dialect kDialect = {.plugins = make_rows(),
                                   .unsupported_types = unsupported_types(),
                                   .unsupported_tags = {"medium", "phase", "volume", "subsurface", "animation"},
                                   .aliases = {{"luminaire", "emitter"}, {"camera", "sensor"}},
                                   .mesh_facts = {.smooth_without_normals = true, .v_origin = VOrigin::top},
                                   .any_spelling = true};
  return kDialect;
}

std::string snake_case(std::string_view name) {
  const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (is_upper(name[i]) && i > 0 && name[i - 1] != '_' && !is_upper(name[i - 1])) out += '_';
    const bool lower = is_upper(name[i]) && name.size() > 1;  // keeps the filter's "A"
    out += lower ? static_cast<char>(name[i] - 'A' + 'a') : name[i];
  }
  return out;
}

bool has_no_effect(const Parameter& parameter) {
  return std::string_view(parameter.doc).starts_with("has no effect");
}

}  // namespace etendue
