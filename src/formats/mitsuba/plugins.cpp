#include "formats/mitsuba/plugins.h"

#include <iterator>
#include <utility>

#include "formats/mesh_formats.h"
#include "scene/limits.h"

namespace etendue {
namespace {

using enum ParameterType;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Range any() {
  return {};
}
Range between(double min, double max) {
  return {min, max, false, false};
}
Range inside(double min, double max) {
  return {min, max, true, true};
}
Range above(double min) {
  return {min, kInfinity, true, false};
}
Range at_least(double min) {
  return {min, kInfinity, false, false};
}

Parameter to_world() {
  return {"to_world", transform, "", any(), "object space to world space; the operations apply in the order listed"};
}
Parameter color_or_texture(const char* name, const char* default_text, const char* doc) {
  return {name, color, default_text, at_least(0), doc, "texture"};
}
/// Begins like all properties that has_no_effect() knows.
Parameter no_effect(const char* name, ParameterType type, const char* doc) {
  return {name, type, "", any(), doc};
}

void append(std::vector<Plugin>& rows, std::vector<Plugin> more) {
  rows.insert(rows.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

std::vector<Plugin> scene_rows() {
  return {{"scene",
           "",
           "The root. Bsdfs, textures and groups of shapes that stand here are used by `<ref>`; what nothing refers to "
           "is not looked at.",
           {},
           {{"integrator", 0, 1},
            {"sensor", 1, kAnyNumber},
            {"emitter", 0, kAnyNumber},
            {"shape", 0, kAnyNumber},
            {"bsdf", 0, kAnyNumber},
            {"texture", 0, kAnyNumber},
            {"film", 0, kAnyNumber},
            {"sampler", 0, kAnyNumber},
            {"rfilter", 0, kAnyNumber}}}};
}

std::vector<Parameter> path_parameters() {
  return {{"max_depth", integer, "-1", between(-1, 1 << 30), "path segments: 1 is emitted light only; -1 is no limit"},
          {"rr_depth", integer, "5", between(1, 1 << 30), "Russian roulette from this segment on"},
          {"hide_emitters", boolean, "false", any(), "whether camera rays see no emitters"}};
}

Plugin as_path(const char* type) {
  return {"integrator", type, "Taken as `path`, which computes the same light.", path_parameters(), {}};
}

std::vector<Plugin> integrator_rows() {
  std::vector<Plugin> rows = {
      {"integrator",
       "path",
       "Path tracing with multiple importance sampling. Without an integrator a scene has this one.",
       path_parameters(),
       {}},
      {"integrator",
       "direct",
       "Light that arrives after at most one reflection.",
       {{"shading_samples", integer, "1", between(0, kMaxDirectSamples), "both of the next two"},
        {"emitter_samples", integer, "1", between(0, kMaxDirectSamples), "samples of lights"},
        {"bsdf_samples", integer, "1", between(0, kMaxDirectSamples), "samples of materials"},
        {"hide_emitters", boolean, "false", any(), "whether camera rays see no emitters"}},
       {}},
      {"integrator",
       "moment",
       "Its child is rendered; every EXR has its standard error anyway.",
       {},
       {{"integrator", 1, 1}}},
      {"integrator",
       "aov",
       "Its child is rendered.",
       {no_effect("aovs", string, "has no effect: only the picture is made")},
       {{"integrator", 1, 1}}},
  };
  for (const char* type : {"ptracer", "bdpt", "mlt", "pssmlt", "erpt", "photonmapper", "ppm", "sppm", "prb",
                           "prb_basic", "prb_projective", "direct_projective", "adjoint_path", "irrcache"})
    rows.push_back(as_path(type));
  return rows;
}

std::vector<Plugin> sensor_rows() {
  return {
      {"sensor",
       "perspective",
       "A pinhole camera: +z forward, +y up, +x to the left of the image.",
       {{"fov", real, "", inside(0, 180), "field of view in degrees along fov_axis"},
        {"focal_length", string, "50mm", any(), "of a lens in front of 36 × 24 mm of film, instead of fov"},
        {"fov_axis", string, "x", any(), "x, y, diagonal, smaller or larger"},
        {"near_clip", real, "0.01", at_least(0), "nearest visible distance along the camera's +z"},
        {"far_clip", real, "10000", above(0), "farthest visible distance along the camera's +z"},
        {"principal_point_offset_x", real, "0", any(), "only 0"},
        {"principal_point_offset_y", real, "0", any(), "only 0"},
        no_effect("focus_distance", real, "has no effect: a pinhole has no focus"),
        no_effect("shutter_open", real, "has no effect: nothing moves"),
        no_effect("shutter_close", real, "has no effect: nothing moves"),
        to_world()},
       {{"film", 0, 1}, {"sampler", 0, 1}}},
  };
}

Plugin film_row(const char* type) {
  return {"film",
          type,
          "Size and filter of the image. The files that are written are those of the command line.",
          {{"width", integer, "768", between(1, 65536), "pixels"},
           {"height", integer, "576", between(1, 65536), "pixels"},
           {"crop_offset_x", integer, "0", between(0, 65536), "only 0"},
           {"crop_offset_y", integer, "0", between(0, 65536), "only 0"},
           {"crop_width", integer, "0", between(0, 65536), "only the width"},
           {"crop_height", integer, "0", between(0, 65536), "only the height"},
           no_effect("pixel_format", string, "has no effect: files hold RGB"),
           no_effect("component_format", string, "has no effect: pictures are half, films exact"),
           no_effect("file_format", string, "has no effect: the name of the output decides"),
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
                   no_effect("seed", integer, "has no effect: the command line gives one"),
                   no_effect("jitter", boolean, "has no effect"),
                   no_effect("scramble", integer, "has no effect: points are always scrambled"),
                   no_effect("dimension", integer, "has no effect")},
                  {}};
  };
  rows.push_back(sampler("independent", "Independent random numbers."));
  for (const char* type : {"stratified", "multijitter", "orthogonal", "ldsampler", "sobol", "halton", "hammersley"})
    rows.push_back(sampler(type, "Taken as `sobol`: scrambled Sobol points in independent sets of 16."));
  append(
      rows,
      {
          {"rfilter", "box", "The pixel's square.", {no_effect("radius", real, "has no effect: half a pixel")}, {}},
          {"rfilter", "tent", "A tent of radius 1 pixel.", {{"radius", real, "1", any(), "only 1"}}, {}},
          {"rfilter",
           "gaussian",
           "A Gaussian of radius 4 standard deviations, lowered to reach zero there; a film's filter if it names none.",
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
      });
  return rows;
}

std::vector<ChildRule> surface() {
  return {{"bsdf", 0, 1}, {"emitter", 0, 1}};
}

Parameter flip_normals() {
  return {"flip_normals", boolean, "false", any(), "turns the surface inside out"};
}
Parameter face_normals() {
  return {"face_normals", boolean, "false", any(), "flat triangles, whatever normals the file has"};
}

std::vector<Plugin> shape_rows() {
  std::vector<Plugin> rows;
  for (const MeshFormat& format : mesh_formats()) {
    const bool flips = std::string_view(format.word) == "obj";
    rows.push_back(
        {"shape",
         format.word,
         format.doc,
         {{"filename", string, nullptr, any(), "the file; looked for in the folders of <path>, then of the scene"},
          face_normals(),
          flip_normals(),
          {"flip_tex_coords", boolean, flips ? "true" : "false", any(), "whether v grows upward in the file"},
          no_effect("collapse", boolean, "has no effect: the file is one mesh"),
          no_effect("max_smooth_angle", real, "has no effect"),
          no_effect("srgb", boolean, "has no effect"),
          to_world()},
         surface()});
  }
  append(
      rows,
      {
          {"shape",
           "serialized",
           "Triangles from a file of Mitsuba's own format.",
           {{"filename", string, nullptr, any(), "the file; looked for in the folders of <path>, then of the scene"},
            {"shape_index", integer, "0", between(0, 4294967295.0), "which of the file's meshes"},
            face_normals(),
            flip_normals(),
            no_effect("max_smooth_angle", real, "has no effect"),
            to_world()},
           surface()},
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
          {"shape", "shapegroup", "Shapes that appear where an `instance` shows them.", {}, {{"shape", 0, kAnyNumber}}},
          {"shape", "instance", "Shows a group of shapes.", {to_world()}, {{"shape", 1, 1}}},
      });
  return rows;
}

std::vector<Parameter> metal_parameters() {
  return {
      {"material", string, "none", any(), "a metal by its name; none reflects everything"},
      color_or_texture("eta", "0 0 0", "real part of the index of refraction"),
      color_or_texture("k", "1 1 1", "imaginary part of the index of refraction"),
      {"ext_eta", real, "vacuum", between(1e-3, 1000), "index of refraction outside, by which eta and k are divided"},
      color_or_texture("specular_reflectance", "1 1 1", "factor of what is reflected")};
}

std::vector<Parameter> rough_metal_parameters() {
  std::vector<Parameter> parameters = metal_parameters();
  const auto alpha = [](const char* name, const char* default_text, const char* doc) {
    return Parameter{name, real, default_text, between(1e-4, 2), doc, "texture"};
  };
  parameters.insert(parameters.end(),
                    {{"distribution", string, "beckmann", any(), "beckmann or ggx"},
                     alpha("alpha", "0.1", "roughness"),
                     alpha("alpha_u", "0.1", "roughness along the tangent, instead of alpha"),
                     alpha("alpha_v", "0.1", "roughness across it"),
                     no_effect("sample_visible", boolean, "has no effect: visible facets are sampled")});
  return parameters;
}

std::vector<Plugin> bsdf_rows() {
  return {
      {"bsdf",
       "diffuse",
       "Lambertian reflection on the side of the normal. Shapes without a bsdf have this one; if they emit, black.",
       {color_or_texture("reflectance", "0.5 0.5 0.5", "reflected share of the light"),
        color_or_texture("diffuse_reflectance", "0.5 0.5 0.5", "another word for reflectance")},
       {}},
      {"bsdf",
       "dielectric",
       "A smooth boundary between two clear media; the normal points to the exterior.",
       {{"int_ior", real, "bk7", between(1e-3, 1000), "index of refraction inside, a number or a name"},
        {"ext_ior", real, "air", between(1e-3, 1000), "index of refraction outside, a number or a name"},
        color_or_texture("specular_reflectance", "1 1 1", "only 1"),
        color_or_texture("specular_transmittance", "1 1 1", "only 1")},
       {}},
      {"bsdf", "conductor", "A smooth metal, seen from the side of the normal.", metal_parameters(), {}},
      {"bsdf", "roughconductor", "A metal with a rough surface of microfacets.", rough_metal_parameters(), {}},
  };
}

std::vector<Plugin> emitter_rows() {
  return {
      {"emitter",
       "area",
       "Makes its shape a light that shines on the side of the shading normal.",
       {color_or_texture("radiance", "1 1 1", "emitted radiance, the same in all directions"),
        no_effect("sampling_weight", real, "has no effect: lights are chosen by what they contribute")},
       {}},
      {"emitter",
       "constant",
       "Light from all around.",
       {color_or_texture("radiance", "1 1 1", "radiance from all directions"),
        no_effect("sampling_weight", real, "has no effect: lights are chosen by what they contribute")},
       {}},
  };
}

std::vector<Plugin> make_rows() {
  std::vector<Plugin> rows = scene_rows();
  append(rows, integrator_rows());
  append(rows, view_rows());
  append(rows, shape_rows());
  append(rows, bsdf_rows());
  append(rows, emitter_rows());
  return rows;
}

std::vector<UnsupportedTypes> unsupported_types() {
  return {
      {"integrator", {"volpath", "volpathmis", "volpath_simple", "depth", "stokes", "ao", "prbvolpath", "vpl"}},
      {"sensor",
       {"thinlens", "orthographic", "telecentric", "radiancemeter", "irradiancemeter", "fluencemeter", "distant",
        "batch", "spherical", "perspective_rdist"}},
      {"film", {"specfilm", "mfilm", "tiledhdrfilm"}},
      {"rfilter", {"lanczos", "spline"}},
      {"shape",
       {"disk", "cylinder", "merge", "heightfield", "hair", "linearcurve", "bsplinecurve", "sdfgrid", "ellipsoids",
        "ellipsoidsmesh"}},
      {"bsdf",
       {"roughdielectric",
        "thindielectric",
        "plastic",
        "roughplastic",
        "principled",
        "principledthin",
        "twosided",
        "mask",
        "blendbsdf",
        "bumpmap",
        "normalmap",
        "null",
        "measured",
        "hair",
        "phong",
        "ward",
        "roughdiffuse",
        "roughcoating",
        "coating",
        "mixturebsdf",
        "difftrans",
        "hk",
        "pplastic",
        "polarizer",
        "retarder",
        "circular",
        "measured_polarized",
        "irawan"}},
      {"emitter",
       {"envmap", "point", "spot", "directional", "directionalarea", "projector", "collimated", "sky", "sun", "sunsky",
        "timed_sunsky"}},
      {"texture",
       {"bitmap", "checkerboard", "mesh_attribute", "volume", "rawconstant", "scale", "gridtexture", "vertexcolors",
        "wireframe", "curvature"}},
  };
}

}  // namespace

const Dialect& mitsuba_dialect() {
  static const Dialect kDialect = {.plugins = make_rows(),
                                   .unsupported_types = unsupported_types(),
                                   .unsupported_tags = {"medium", "phase", "volume", "subsurface"},
                                   .aliases = {{"luminaire", "emitter"}, {"camera", "sensor"}},
                                   .mesh_facts = {.smooth_without_normals = true, .v_origin = VOrigin::top}};
  return kDialect;
}

std::string snake_case(std::string_view name) {
  const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  std::string out;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (is_upper(name[i]) && i > 0 && name[i - 1] != '_' && !is_upper(name[i - 1])) out += '_';
    const bool lower = is_upper(name[i]) && name.size() > 1;  // "A" of the filter stays
    out += lower ? static_cast<char>(name[i] - 'A' + 'a') : name[i];
  }
  return out;
}

bool has_no_effect(const Parameter& parameter) {
  return std::string_view(parameter.doc).starts_with("has no effect");
}

}  // namespace etendue
