#include "formats/nori/plugins.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "formats/mesh_formats.h"
#include "scene/limits.h"

namespace etendue {
namespace {

using enum ParameterType;
using namespace ranges;

constexpr double kUint32Max = 4294967295.0;
constexpr double kMaxDepth = 1 << 30;

Parameter world_transform() {
  return {"toWorld", transform, "", any(), "object space to world space; the operations apply in the order listed"};
}

Parameter light_sampler() {
  return {"lightSampler", string, "auto", any(),
          "how next-event estimation chooses a light: power, by power alone; tree, by its possible contribution to the "
          "point; auto, tree for 10 or more emitting primitives, otherwise power"};
}

Parameter hide_emitters() {
  return {"hideEmitters", boolean, "false", any(),
          "camera rays pass through emitters and see no sky; the light they send elsewhere stays"};
}

std::vector<Parameter> alias_parameters() {
  return {{"maxDepth", integer, "1073741824", between(1, kMaxDepth), "path segments; by default unlimited"},
          {"rrDepth", integer, "5", between(1, kMaxDepth), "Russian roulette from this segment on"},
          light_sampler(),
          hide_emitters()};
}

std::vector<Plugin> scene_plugins() {
  return {
      {"scene",
       "",
       "The root of a rendered file.",
       {{"sky_top", color, "0 0 0", between(0, kMaxRadiance), "radiance from straight above"},
        {"sky_horizon", color, "0 0 0", between(0, kMaxRadiance), "radiance from the horizon and below"},
        {"envmap", string, "", any(), "file of a picture of the sky, as of an emitter envmap"},
        {"envmapScale", real, "1", at_least(0), "factor of that picture's radiance; 0: no sky"},
        {"nee", boolean, "true", any(), "next-event estimation, unless the integrator sets it"},
        {"instancing", string, "auto", any(),
         "whether a mesh that several shapes share is stored once: auto, if the copies would be large; never; always, "
         "even if it is used once"}},
       {{"integrator", 0, 1, ChildUse::element},
        {"camera", 1, 1, ChildUse::element},
        {"sampler", 0, 1, ChildUse::element},
        {"mesh", 0, kAnyNumber, ChildUse::element},
        {"emitter", 0, kAnyNumber, ChildUse::element},
        {"bsdf", 0, kAnyNumber, ChildUse::definition}}},
  };
}

/// Path tracing under the names used by Nori's courses and by renderers with media.
std::vector<Plugin> path_aliases() {
  std::vector<Plugin> rows;
  const auto add = [&](const char* type, const char* doc) {
    rows.push_back({"integrator", type, doc, alias_parameters(), {}});
  };
  add("path_mats", "Path tracing by material sampling only: path with nee off, and no depth limit.");
  add("path_ems",
      "Path tracing with light sampling only at diffuse vertices: path with nee on and mis off, and no depth limit.");
  add("path_mis", "Path tracing with multiple importance sampling: path with nee and mis on, and no depth limit.");
  add("path_simple", "Another name for path_mats.");
  add("path_vol", "The same as path_mis, since there are no media.");
  add("volpath", "The same as path_mis, since there are no media.");
  add("vol_path", "The same as path_mis, since there are no media.");
  add("vol_path_mats", "The same as path_mats, since there are no media.");
  add("vol_path_mis", "The same as path_mis, since there are no media.");
  add("photonmapper", "Read as path_mis, which computes the same light without the blur of photon maps.");
  add("bdpt", "Read as path_mis, which computes the same light.");
  add("mlt", "Read as path_mis, which computes the same light.");
  return rows;
}

std::vector<Parameter> direct_parameters() {
  return {light_sampler(), hide_emitters()};
}

std::vector<Plugin> direct_plugins() {
  return {
      {"integrator",
       "direct",
       "Direct light only: emitters and sky seen by the camera, and their light reflected by the first surface. "
       "Mirrors and glass show emitters through material samples.",
       {{"emitterSamples", integer, "1", between(0, kMaxDirectSamples), "light samples per camera ray"},
        {"bsdfSamples", integer, "1", between(0, kMaxDirectSamples),
         "material samples per camera ray; both kinds are combined by multiple importance sampling"},
        light_sampler(),
        hide_emitters()},
       {}},
      {"integrator",
       "direct_ems",
       "direct with one light sample and no material sample: mirrors and glass are black.",
       direct_parameters(),
       {}},
      {"integrator", "direct_mats", "direct with one material sample and no light sample.", {hide_emitters()}, {}},
      {"integrator", "direct_mis", "direct with one sample of each kind.", direct_parameters(), {}},
      {"integrator",
       "whitted",
       "Direct light, from one light sample, at the first surface that is neither mirror nor glass. At each mirror or "
       "glass surface the path continues with probability 0.95.",
       direct_parameters(),
       {}},
  };
}

std::vector<Plugin> first_hit_plugins() {
  return {
      {"integrator",
       "normals",
       "The shading normal of the first hit as a colour: |n| of each component.",
       {{"signed", boolean, "false", any(), "show (n + 1)/2 instead"}},
       {}},
      {"integrator",
       "simple",
       "Lights the first hit with a single point light, ignoring emitters and materials: energy/(4π²) · max(0, cos "
       "θ)/d², or 0 in shadow.",
       {{"position", point, nullptr, between(-kMaxCoordinate, kMaxCoordinate), "position of the light in world space"},
        {"energy", color, nullptr, between(0, kMaxRadiance), "power of the light"}},
       {}},
      {"integrator",
       "ao",
       "Ambient occlusion: 1 if a cosine-distributed ray from the first hit is not blocked, otherwise 0.",
       {{"length", real, "0", between(0, kMaxCoordinate), "length of that ray; 0: infinite"}},
       {}},
      {"integrator",
       "av",
       "Average visibility: 1 if a ray from the first hit, uniformly distributed over the hemisphere, is not blocked "
       "or there is no hit, otherwise 0.",
       {{"length", real, nullptr, above_up_to(0, kMaxCoordinate), "length of that ray"}},
       {}},
      {"integrator", "depth", "1 divided by the distance between camera and first hit; 0 if there is none.", {}, {}},
      {"integrator",
       "distance",
       "Distance along the ray from the near clipping plane to the first hit; 0 if there is none.",
       {},
       {}},
  };
}

std::vector<Plugin> integrator_plugins() {
  std::vector<Plugin> rows = {
      {"integrator",
       "path",
       "Path tracing.",
       {{"maxDepth", integer, "16", between(1, kMaxDepth),
         "path segments; the camera ray is the first, so 1 is emitted light only and 2 adds direct light"},
        {"nee", boolean, "true", any(), "next-event estimation: one shadow ray to a light at every diffuse vertex"},
        {"mis", boolean, "true", any(), "multiple importance sampling of lights and materials; no effect without nee"},
        {"rrDepth", integer, "5", between(0, kMaxDepth), "Russian roulette from this segment on; 0 is off"},
        {"countPasses", boolean, "true", any(),
         "whether passing through a mask or null counts as the end of a segment"},
        light_sampler(),
        hide_emitters()},
       {}}};
  for (const auto& more : {path_aliases(), direct_plugins(), first_hit_plugins()})
    rows.insert(rows.end(), more.begin(), more.end());
  for (Plugin& row : rows) {
    const bool light =
        std::ranges::find(row.parameters, std::string_view("hideEmitters"), &Parameter::name) != row.parameters.end();
    if (light)
      row.parameters.push_back({"hideBackground", boolean, "false", any(),
                                "camera rays that hit nothing see no sky; `render --alpha` sets it"});
    row.parameters.push_back(
        {"aovs", string, "", any(), "additional channels, separated by commas: depth, normal, albedo …"});
  }
  return rows;
}

/// Parameters that every camera has.
std::vector<Parameter> film_parameters(const char* width, const char* height) {
  return {{"width", integer, width, between(1, 65536), "pixels; width · height is at most 67108864"},
          {"height", integer, height, between(1, 65536), "pixels"},
          {"cropWidth", integer, "0", between(0, 65536),
           "width of the rendered part of the film in pixels; 0: up to the right edge"},
          {"cropHeight", integer, "0", between(0, 65536), "height of the rendered part; 0: down to the lower edge"},
          {"cropOffsetX", integer, "0", between(0, 65535), "pixels to the left of the rendered part"},
          {"cropOffsetY", integer, "0", between(0, 65535), "pixels above the rendered part"},
          {"nearClip", real, "1e-4", between(0, kMaxCoordinate), "nearest visible distance along the camera's +Z"},
          {"farClip", real, "1e4", above(0), "farthest visible distance along the camera's +Z; more than nearClip"},
          {"path", string, "spline", any(), "how positions between keyframes are interpolated: spline or linear"},
          world_transform()};
}

/// Cameras with a field of view.
std::vector<Parameter> perspective_parameters() {
  std::vector<Parameter> parameters = {
      {"fov", real, "30", inside(0, 180), "field of view in degrees, along fovAxis"},
      {"fovAxis", string, "x", any(),
       "direction in which fov is measured: x, y, diagonal, or the smaller or larger side of the film"},
      {"focalLength", real, "0", between(0, 1e6),
       "focal length in millimetres for 36 × 24 mm film, which sets the diagonal field of view; 0: use fov"},
      {"principalPointOffsetX", real, "0", between(-100, 100),
       "moves the picture to the left relative to the camera's axis, in widths of the film"},
      {"principalPointOffsetY", real, "0", between(-100, 100), "moves the picture up, in heights of the film"}};
  const std::vector<Parameter> film = film_parameters("1280", "720");
  parameters.insert(parameters.begin(), film.begin(), film.begin() + 2);
  parameters.insert(parameters.end(), film.begin() + 2, film.end());
  return parameters;
}

std::vector<Plugin> camera_plugins() {
  std::vector<Parameter> pinhole = perspective_parameters(), lens = pinhole;
  const Range radius = between(0, kMaxCoordinate);
  pinhole.insert(pinhole.end() - 1, {{"dof", boolean, "true", any(), "whether there is that lens"},
                                     {"apertureRadius", real, "0", radius, "above 0: a lens as in thinlens"},
                                     {"focusDistance", real, "", above(0),
                                      "distance of that lens's plane of focus along the camera's +Z"}});
  lens.insert(lens.end() - 1,
              {{"apertureRadius", real, nullptr, radius, "radius of the lens, in camera units"},
               {"focusDistance", real, nullptr, above(0), "distance of the plane of focus along the camera's +Z"},
               {"blades", integer, "0", between(0, 1000), "corners of a polygonal aperture; 0: a disk"},
               {"bladeRotation", real, "0", between(-360, 360),
                "rotates the first corner from the camera's +X toward +Y, in degrees"}});
  const std::vector<ChildRule> filter = {{"rfilter", 0, 1}, {"keyframe", 0, kAnyNumber, ChildUse::element}};
  return {
      {"camera", "perspective", "A pinhole camera: +Z forward, +Y up, +X to the left of the image.", pinhole, filter},
      {"camera", "thinlens",
       "A perspective camera with a lens of finite size: everything off the focus distance is blurred. A point at "
       "depth z becomes a spot of radius apertureRadius · |1 − z/focusDistance|, measured at that depth.",
       lens, filter},
      {"camera", "orthographic",
       "All rays are parallel to the camera's +Z. The film is two camera units wide; a scale in toWorld widens it.",
       film_parameters("1280", "720"), filter},
      {"camera", "spherical",
       "A panorama of all directions: longitude runs across, with +Z in the middle and +X to the left of it; +Y is at "
       "the upper edge. Clipping distances are measured along the rays.",
       film_parameters("1280", "640"), filter},
      {"camera", "radiancemeter", "A single ray along +Z from the camera's position: every pixel measures the same.",
       film_parameters("1", "1"), filter},
      {"camera", "irradiancemeter",
       "The irradiance of the square from −1 to 1 in the camera's x and y, on the side of +Z; the film covers the "
       "square.",
       film_parameters("1", "1"), filter},
  };
}

std::vector<Plugin> view_plugins() {
  return {
      {"keyframe",
       "",
       "The position of a camera at a given time; a child of <camera>, instead of its toWorld. --at and render "
       "--frames set the time; otherwise it is 0.",
       {{"time", real, nullptr, between(-1e6, 1e6), "seconds; later than the previous keyframe"},
        {"toWorld", transform, "", any(), "camera space to world space at that time"}},
       {}},
      {"sampler",
       "independent",
       "Independent random numbers.",
       {{"sampleCount", integer, "1", between(1, kUint32Max), "samples per pixel"}},
       {}},
      {"sampler",
       "sobol",
       "Owen-scrambled Sobol points: less noise for the same number of samples. A pixel's samples come in sets of "
       "setSize that are independent of each other; standard errors, films and tests count sets.",
       {{"sampleCount", integer, "1", between(1, kUint32Max), "samples per pixel; rounded up to whole sets"},
        {"setSize", integer, "16", between(2, 4096), "samples in a set, a power of two"}},
       {}},
      {"rfilter",
       "box",
       "The pixel's square; the default in tests.",
       {{"radius", real, "0.5", above_up_to(0, 32), "pixels"}},
       {}},
      {"rfilter", "tent", "A tent.", {{"radius", real, "1", above_up_to(0, 32), "pixels"}}, {}},
      {"rfilter",
       "gaussian",
       "A Gaussian, lowered to reach zero at the radius; the default, as in Nori.",
       {{"radius", real, "2", above_up_to(0, 32), "pixels"},
        {"stddev", real, "0.5", above_up_to(0, 32), "standard deviation in pixels"}},
       {}},
      {"rfilter",
       "mitchell",
       "The filter of Mitchell and Netravali, which has negative lobes.",
       {{"radius", real, "2", above_up_to(0, 32), "pixels"},
        {"B", real, "0.3333333333333333", between(-8, 8), "blur"},
        {"C", real, "0.3333333333333333", between(-8, 8), "ringing"}},
       {}},
      {"rfilter",
       "lanczos",
       "A windowed sinc function; every second lobe is negative.",
       {{"lobes", integer, "3", between(1, kMaxFilterLobes), "radius in pixels"}},
       {}},
  };
}

std::vector<ChildRule> surface() {
  return {{"bsdf", 0, 1}, {"emitter", 0, 1}};
}

Parameter flip_normals() {
  return {"flipNormals", boolean, "false", any(), "reverses the normals"};
}

Parameter mesh_texture() {
  return {"texture", color, "1 1 1", between(0, 1), "a texture instead of the colour of its material", "texture"};
}

/// One row for each type of mesh file.
std::vector<Plugin> mesh_file_plugins() {
  std::vector<Plugin> rows;
  for (const MeshFormat& format : mesh_formats()) {
    rows.push_back({"mesh",
                    format.word,
                    format.doc,
                    {{"filename", string, nullptr, any(), "the file, relative to the folder of the scene file"},
                     world_transform(),
                     flip_normals(),
                     normals_parameter(),
                     mesh_texture()},
                    surface()});
  }
  return rows;
}

std::vector<Plugin> object_plugins() {
  return {
      {"mesh",
       "sphere",
       "An exact sphere. Its transform may rotate, move and scale it uniformly; if it only rotates, and not by a "
       "<matrix>, it turns the sphere about its center.",
       {{"center", point, "0 0 0", between(-kMaxCoordinate, kMaxCoordinate), "object space"},
        {"radius", real, "1", above_up_to(0, kMaxCoordinate), "scene units"},
        world_transform(),
        flip_normals(),
        normals_parameter(),
        mesh_texture()},
       surface()},
      {"emitter",
       "area",
       "Makes its mesh a light that emits on the side of the geometric normal.",
       {{"radiance", color, nullptr, between(0, kMaxRadiance), "emitted radiance, the same in all directions",
         "texture"},
        {"scale", real, "1", between(0, kMaxRadiance), "factor of the radiance"},
        {"two_sided", boolean, "false", {}, "emit on both sides; for meshes and disks"}},
       {}},
      {"emitter",
       "constant",
       "Uniform light from all directions; a child of <scene>, instead of sky_top and sky_horizon.",
       {{"radiance", color, "1 1 1", between(0, kMaxRadiance), "radiance from every direction"}},
       {}},
      {"emitter",
       "envmap",
       "Light from all directions, given by a latitude-longitude picture, +Y up; a child of <scene>, instead of "
       "sky_top and sky_horizon. The left and right edges of the picture are toward -Z, the middle is toward +Z, and "
       "+X is a quarter of the width from the left. PNG and JPEG are read as sRGB, OpenEXR and Radiance HDR as linear.",
       {{"filename", string, "", any(), "the picture, relative to the folder of the scene file"},
        {"radiance", color, "1 1 1", between(0, kMaxRadiance), "grey factor; or a texture, the picture", "texture"},
        {"scale", real, "1", above(0), "factor of the picture's radiance"},
        {"up", string, "", any(),
         "the axis toward the upper edge of the picture, before toWorld: y as described, or z with the left edge "
         "toward +X and +Y a quarter of the width from it; the default is y, but z in a mesh, where toWorld turns +Z "
         "to +Y, and where the camera has +Z up and toWorld leaves it there"},
        {"rows", string, "bands", any(),
         "bands: each row of the picture is the middle of a band, all of equal height; circles: the first and last "
         "rows are the poles, as in Mitsuba"},
        {"toWorld", transform, "", any(),
         "rotates or reflects the picture, whose axes are described above; scale and translation have no effect"}},
       {}},
  };
}

std::vector<Plugin> test_plugins() {
  return {
      {"test",
       "ttest",
       "Do mean values agree with references? Run with `etendue ttest`. There is one reference for each scene, or for "
       "each bsdf and angle.",
       {{"references", number_list, nullptr, any(), "expected mean luminance, in the order of the children"},
        {"angles", number_list, "", between(0, 180),
         "angles of incidence in degrees from the normal, above 90 from behind, not 90 itself; only with bsdfs"},
        {"uv", number_list, "0.3, 0.6", any(), "texture coordinates at which the bsdfs are tested"},
        {"significanceLevel", real, "0.01", inside(0, 1), "probability of a false alarm for the whole test"},
        {"sampleCount", integer, "100000", between(2, 1e12), "samples per scene, or per bsdf and angle"}},
       {{"scene", 0, kAnyNumber, ChildUse::element}, {"bsdf", 0, kAnyNumber}}},
      {"test",
       "chi2test",
       "Does sampling match its density? Run with `etendue chi2`.",
       {{"significanceLevel", real, "0.01", inside(0, 1), "probability of a false alarm for the whole test"},
        {"resolution", integer, "10", between(2, 1000),
         "cells in the cosine of the polar angle; twice as many in azimuth"},
        {"minExpFrequency", real, "5", between(1, 1e6), "cells with fewer expected samples are pooled"},
        {"sampleCount", integer, "0", between(0, 1e12), "samples per test; 0 is 5000 per cell"},
        {"testCount", integer, "5", between(1, 1e6), "directions of incidence per bsdf, or per angle"},
        {"angles", number_list, "", between(0, 180),
         "angles of incidence in degrees from the normal, above 90 from behind, not 90 itself; none: random, on the "
         "sides from which a bsdf reflects light"},
        {"uv", number_list, "0.3, 0.6", any(), "texture coordinates at which the bsdfs are tested"}},
       {{"bsdf", 1, kAnyNumber}}},
  };
}

std::vector<Plugin> shape_plugins() {
  const Range anywhere = between(-kMaxCoordinate, kMaxCoordinate);
  return {{"mesh",
           "rectangle",
           "The square from (−1, −1, 0) to (1, 1, 0) with normal +z: a mesh of two triangles with texture coordinates.",
           {world_transform(), flip_normals()},
           surface()},
          {"mesh",
           "parallelogram",
           "The corners origin, origin + u, origin + u + v and origin + v, with the normal u × v: a mesh of two "
           "triangles with texture coordinates.",
           {{"origin", point, "-1 -1 0", anywhere, "a corner"},
            {"u", vector, "2 0 0", anywhere, "an edge"},
            {"v", vector, "0 2 0", anywhere, "the other edge"},
            world_transform(),
            flip_normals()},
           surface()},
          {"mesh",
           "cube",
           "The cube from (−1, −1, −1) to (1, 1, 1) with outward normals: a mesh of twelve triangles with texture "
           "coordinates.",
           {world_transform(), flip_normals()},
           surface()},
          {"mesh",
           "disk",
           "An exact disk of radius 1 around the origin in the plane z = 0, with normal +z. Any transform is allowed "
           "and may make it an ellipse.",
           {world_transform(), flip_normals()},
           surface()},
          {"mesh",
           "cylinder",
           "The exact side of a cylinder, open at both ends, with outward normals. Its transform may rotate, move and "
           "scale it uniformly.",
           {{"p0", point, "0 0 0", anywhere, "one end of the axis, in object space"},
            {"p1", point, "0 0 1", anywhere, "the other end"},
            {"radius", real, "1", above_up_to(0, kMaxCoordinate), "scene units"},
            world_transform(),
            flip_normals()},
           surface()}};
}

std::vector<Plugin> instance_plugins() {
  return {
      {"mesh",
       "shapegroup",
       "Shapes that are visible only where an instance shows them; the group needs an id. Its meshes are stored once, "
       "for any number of instances.",
       {},
       {{"mesh", 1, kAnyNumber, ChildUse::element}}},
      {"mesh",
       "instance",
       "A copy of a shape group, given by a <ref>: all of its shapes, with their materials and emitters. An emitter in "
       "the group emits from every instance.",
       {world_transform()},
       {{"mesh", 1, 1}}},
  };
}

std::vector<Plugin> make_plugins() {
  std::vector<Plugin> rows = scene_plugins();
  for (Plugin& row : integrator_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : camera_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : view_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : mesh_file_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : shape_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : instance_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : object_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : test_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : delta_light_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : daylight_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : bsdf_plugins()) rows.push_back(std::move(row));
  for (Plugin& row : texture_plugins()) rows.push_back(std::move(row));
  return rows;
}

std::vector<UnsupportedTypes> unsupported_types() {
  return {
      {"integrator", {"irradiance_cache", "vpl", "radiosity"}},
      {"camera", {"environment", "fisheye"}},
      {"rfilter", {"catmullrom"}},
      {"mesh", {"serialized", "heightfield"}},
      {"bsdf",
       {"phong", "blinnphong", "ward", "orennayar", "roughdiffuse", "hair", "subsurface", "bssrdf", "dipole", "merl",
        "layered"}},
  };
}

}  // namespace

const Dialect& nori_dialect() {
  static const Dialect kDialect = {
      .plugins = make_plugins(),
      .unsupported_types = unsupported_types(),
      .unsupported_tags = {"medium", "phase", "volume"},
      .aliases = {{"shape", "mesh"}, {"luminaire", "emitter"}, {"envmap", "emitter"}, {"diffusemap", "texture"}},
      .mesh_facts = {.smooth_without_normals = false, .v_origin = VOrigin::bottom},
      .type_aliases = nori_type_aliases(),
      .parameter_aliases = nori_parameter_aliases(),
      .any_spelling = true,
      .forgiving = true,
      .ignored_tags = nori_ignored_tags(),
      .ignored_properties = nori_ignored_properties(),
      .unsupported_properties = nori_unsupported_properties()};
  return kDialect;
}

}  // namespace etendue
