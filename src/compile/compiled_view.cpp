#include "compile/compiled_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "compile/filter_table.h"
#include "image/vectors.h"
#include "scene/film_unit.h"

namespace etendue {
namespace {

// A power of two that scales the camera's axes so that their squares fit a float; 1 for any usual camera. toWorld may
// scale by anything that a double can hold, but only the directions matter.
double camera_unit(const glm::dmat4& world_from_camera, double tan_x, double tan_y) {
  double largest = 0.0;
  for (int a = 0; a < 3; ++a) {
    largest = std::max({largest, std::abs(world_from_camera[0][a]) * tan_x, std::abs(world_from_camera[1][a]) * tan_y,
                        std::abs(world_from_camera[2][a])});
  }
  constexpr int kUsual = 40;
  const int exponent = std::ilogb(largest);
  return std::abs(exponent) <= kUsual ? 1.0 : std::ldexp(1.0, exponent);
}

/// If the camera is farther than this from the scene, in normalised units, its rays begin just in front of the scene.
constexpr double kFarCamera = 16.0;

/// Camera depth of a plane slightly in front of the whole scene; 0 if the scene reaches to the camera or behind it.
/// Normalised scenes fill the cube from −1 to 1.
double depth_before_scene(const Normalization& n, const glm::dmat4& world_from_camera) {
  const glm::dmat4 camera_from_world = glm::inverse(world_from_camera);
  const double middle = (camera_from_world * glm::dvec4(n.center, 1.0)).z;
  double half = 0.0;
  for (int axis = 0; axis < 3; ++axis) half += std::abs(camera_from_world[axis].z) / n.scale;
  constexpr double kMargin = 1.125;
  const double depth = middle - kMargin * half;
  return depth > 0.0 && std::isfinite(depth) ? depth : 0.0;
}

gpu::uint integrator_id(Integrator::Type type) {
  switch (type) {
    case Integrator::Type::path:
      return gpu::kIntegratorPath;
    case Integrator::Type::normals:
      return gpu::kIntegratorNormals;
    case Integrator::Type::absolute_normals:
      return gpu::kIntegratorAbsoluteNormals;
    case Integrator::Type::direct:
      return gpu::kIntegratorDirect;
    case Integrator::Type::whitted:
      return gpu::kIntegratorWhitted;
    case Integrator::Type::simple:
      return gpu::kIntegratorSimple;
    case Integrator::Type::ambient_occlusion:
      return gpu::kIntegratorAmbientOcclusion;
    case Integrator::Type::visibility:
      return gpu::kIntegratorVisibility;
    case Integrator::Type::depth:
      return gpu::kIntegratorDepth;
    case Integrator::Type::distance:
      return gpu::kIntegratorDistance;
    case Integrator::Type::aov:
      return gpu::kIntegratorAov;
  }
  throw std::logic_error("an integrator without a kernel");
}

static_assert(static_cast<gpu::uint>(Aov::hit) == gpu::kAovHit);
static_assert(static_cast<gpu::uint>(Aov::material) == gpu::kAovLastAtHit);
static_assert(static_cast<gpu::uint>(Aov::albedo) == gpu::kAovAlbedo);
static_assert(static_cast<gpu::uint>(Integrator::LightPart::direct) == gpu::kLightPartDirect);
static_assert(static_cast<gpu::uint>(Integrator::LightPart::indirect) == gpu::kLightPartIndirect);

void set_integrator(const SceneFacts& scene, const Integrator& integrator, CompiledView& out) {
  const Normalization& n = scene.normalization;
  gpu::Frame& f = out.frame;
  out.integrator = integrator_id(integrator.type);
  const bool path = integrator.type == Integrator::Type::path, whitted = integrator.type == Integrator::Type::whitted;
  const bool aov = integrator.type == Integrator::Type::aov;
  f.max_depth = path ? integrator.max_depth : aov ? gpu::kMaxAovSegments : Integrator::kUnlimitedDepth;
  f.aov = static_cast<gpu::uint>(integrator.aov);
  out.light_part = static_cast<gpu::uint>(integrator.light_part);
  // Roulette applies after every mirror for whitted, and nowhere for direct.
  f.rr_depth = path && integrator.rr_depth > 0 ? integrator.rr_depth : whitted ? 1 : gpu::kNone;
  if (integrator.type != Integrator::Type::distance) f.ray_length = static_cast<float>(integrator.length * n.scale);
  f.light_position = n.point(integrator.light.position);
  f.light_intensity = glm::vec3(integrator.light.energy * (n.scale * n.scale / (4.0 * kPi * kPi)));
  f.emitter_samples = integrator.emitter_samples;
  f.bsdf_samples = integrator.bsdf_samples;
}

/// Half of the film's width and height at depth 1; 0 if all rays are parallel.
glm::dvec2 slopes(const Camera& camera) {
  if (camera.type != Camera::Type::perspective && camera.type != Camera::Type::thin_lens) return glm::dvec2(0.0);
  const double half = std::tan(0.5 * camera.fov * kPi / 180.0), aspect = film_aspect(camera);
  using Axis = Camera::FovAxis;
  double tan_x = half;
  if (camera.fov_axis == Axis::y || (camera.fov_axis == Axis::smaller && aspect < 1.0) ||
      (camera.fov_axis == Axis::larger && aspect > 1.0))
    tan_x = half / aspect;
  if (camera.fov_axis == Axis::diagonal) tan_x = half / std::sqrt(1.0 + aspect * aspect);
  return {tan_x, camera.window.whole() ? tan_x * camera.height / camera.width : tan_x * aspect};
}

gpu::uint camera_kind(const Camera& camera, bool far) {
  switch (camera.type) {
    case Camera::Type::perspective:
      return far ? gpu::kCameraPlane : gpu::kCameraPinhole;
    case Camera::Type::thin_lens:
      return gpu::kCameraLens;
    case Camera::Type::orthographic:
    case Camera::Type::radiance_meter:
      return gpu::kCameraPlane;
    case Camera::Type::spherical:
      return gpu::kCameraSpherical;
    case Camera::Type::irradiance_meter:
      return gpu::kCameraIrradiance;
  }
  throw std::logic_error("a camera without a kernel");
}

void set_window(const Camera& camera, CompiledView& out) {
  const FilmWindow& w = camera.window;
  out.window = !w.whole();
  out.frame.window_offset = glm::vec2(1.0 - 2.0 * (w.origin + w.principal_offset));
  out.frame.window_scale = glm::vec2(2.0 * w.size / glm::dvec2(camera.width, camera.height));
}

void set_camera(const SceneFacts& scene, const Camera& camera, CompiledView& out) {
  const Normalization& n = scene.normalization;
  const glm::dmat4& m = camera.world_from_camera;
  gpu::Frame& f = out.frame;
  const glm::dvec2 tan = slopes(camera);
  const bool from_plane = camera.type == Camera::Type::orthographic || camera.type == Camera::Type::irradiance_meter;
  // Beyond this, a scene of size 1 is far below what single precision can resolve, and squares would overflow.
  const glm::dvec3 farthest(0x1p60);
  const bool has_depth = camera.type != Camera::Type::spherical && camera.type != Camera::Type::irradiance_meter;
  const double before_scene = has_depth ? depth_before_scene(n, m) : 0.0;
  const bool far = before_scene * glm::length(glm::dvec3(m[2])) * n.scale > kFarCamera;
  const double plane = far ? before_scene : 0.0;
  out.camera = camera_kind(camera, far);
  const glm::dvec3 origin = (glm::dvec3(m[3]) + plane * glm::dvec3(m[2]) - n.center) * n.scale;
  f.camera_origin = glm::vec3(glm::clamp(origin, -farthest, farthest));
  const double unit = camera_unit(m, tan.x, tan.y);
  f.camera_x = glm::vec3(m[0] / unit);
  f.camera_y = glm::vec3(m[1] / unit);
  f.camera_z = glm::vec3(m[2] / unit);
  f.near_clip = static_cast<float>(std::max(camera.near_clip - plane, 0.0) * n.scale * unit);
  f.ray_length = far ? static_cast<float>(std::max(1.0 - camera.near_clip / plane, 0.0)) : 0.0f;
  f.far_clip = static_cast<float>(std::max(camera.far_clip - plane, 0.0) * n.scale * unit);
  f.tan_x = static_cast<float>(tan.x);
  f.tan_y = static_cast<float>(tan.y);
  const double aspect = camera.type == Camera::Type::irradiance_meter ? 1.0 : film_aspect(camera);
  const glm::dvec2 half = from_plane ? glm::dvec2(1.0, aspect) : plane * tan;
  f.plane_x = static_cast<float>(half.x * n.scale * unit);
  f.plane_y = static_cast<float>(half.y * n.scale * unit);
  f.plane_depth = static_cast<float>(plane * n.scale * unit);
  const Aperture& lens = camera.aperture;
  f.lens_offset = static_cast<float>(lens.radius * (1.0 - plane / lens.focus_distance) * n.scale * unit);
  f.lens_slope = static_cast<float>(-lens.radius / lens.focus_distance);
  f.lens_rotation = static_cast<float>(lens.rotation / 360.0 - std::floor(lens.rotation / 360.0));
  f.lens_blades = lens.blades;
  set_window(camera, out);
}

}  // namespace

CompiledView compile_view(const SceneFacts& scene, const View& view, std::uint32_t seed) {
  const Normalization& n = scene.normalization;
  const Camera& camera = view.camera;
  CompiledView out;
  gpu::Frame& f = out.frame;
  f.seed = seed;
  set_camera(scene, camera, out);
  f.sky_top = glm::vec3(scene.environment.top);
  f.sky_horizon = glm::vec3(scene.environment.horizon);
  f.sky_x = glm::vec3(scene.environment.world_from_sky[0]);
  f.sky_y = glm::vec3(scene.environment.world_from_sky[1]);
  f.sky_z = glm::vec3(scene.environment.world_from_sky[2]);
  f.environment_row_count = scene.environment.row_count;
  f.environment_threshold = scene.environment.threshold;
  f.lights_prob = static_cast<float>(scene.environment.lights_prob);
  f.distant_threshold = scene.environment.distant_threshold;
  f.delta_light_limit = static_cast<float>(delta_light_limit(scene.radiance_exponent));
  f.distance_scale = static_cast<float>(n.scale);
  f.scene_center = glm::vec3(n.center);
  f.width = camera.width;
  f.height = camera.height;
  f.tiles_x = (camera.width + gpu::kTileSize - 1) / gpu::kTileSize;
  set_integrator(scene, view.integrator, out);
  f.film_exponent = view_exponent(view, scene.radiance_exponent, scene.bounds);
  f.light_instance_count = scene.light_instance_count;
  const FilterTable table = make_filter_table(camera.filter);
  f.filter_weight = static_cast<float>(table.weight);
  f.filter_zero = table.turns_negative ? static_cast<float>(table.zero) : INFINITY;
  out.filter = table.knots.empty() ? gpu::kFilterBox : table.alternates ? gpu::kFilterAlternating : gpu::kFilterTable;
  out.filter_knots = table.knots;
  return out;
}

}  // namespace etendue
