#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "validate/closed_form.h"
#include "validate/closed_form_dice.h"

namespace etendue {
namespace {

using namespace closed_form;

/// Box whose faces look inward.
TriangleMesh inward_box(const dvec3& half) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      dvec3 corner(0.0), u(0.0), v(0.0);
      corner[axis] = side * half[axis];
      u[(axis + 1) % 3] = half[(axis + 1) % 3];
      v[(axis + 2) % 3] = -side * half[(axis + 2) % 3];  // u × v points inward
      const auto base = static_cast<std::uint32_t>(mesh.positions.size());
      for (const dvec3& p : {corner - u - v, corner + u - v, corner + u + v, corner - u + v})
        mesh.positions.push_back(p);
      mesh.triangles.emplace_back(base, base + 1, base + 2);
      mesh.triangles.emplace_back(base, base + 2, base + 3);
    }
  }
  return mesh;
}

dvec3 sky_radiance(const Sky& sky, const dvec3& d) {
  return glm::mix(sky.horizon, sky.top, std::clamp(d.y, 0.0, 1.0));
}

dvec3 reflect_about(const dvec3& wo, const dvec3& n) {
  return 2.0 * glm::dot(wo, n) * n - wo;
}

// --- direct

/// The cone a light lives in: no two of them overlap as seen from the origin, so that lights never hide each other.
struct Cone {
  dvec3 axis;
  double angle;
};

/// How many lights, and how large as seen from the origin.
struct Crowd {
  int least, most;
  double least_angle, most_angle;
};
constexpr Crowd kFewLights{1, 6, 0.12, 0.5}, kManySmallLights{40, 80, 0.04, 0.1};

std::vector<Cone> disjoint_cones(Dice& dice, const Crowd& crowd) {
  const int count = dice.between_int(crowd.least, crowd.most);
  std::vector<Cone> cones;
  for (int attempt = 0; attempt < 1000 && static_cast<int>(cones.size()) < count; ++attempt) {
    const Cone c{dice.direction(), dice.between(crowd.least_angle, crowd.most_angle)};
    if (c.axis.y < -0.5) continue;  // a light far below the floor tests no more than one just below
    const bool apart = std::all_of(cones.begin(), cones.end(), [&](const Cone& other) {
      return std::acos(std::clamp(glm::dot(c.axis, other.axis), -1.0, 1.0)) > 1.05 * (c.angle + other.angle);
    });
    if (apart) cones.push_back(c);
  }
  return cones;
}

/// A convex polygon that touches the cone's surface, its plane tilted, its front toward the origin.
std::vector<dvec3> polygon_in_cone(Dice& dice, const Cone& cone, double distance) {
  const int corners = dice.between_int(3, 6);
  const auto [s, t] = tangents(cone.axis);
  const dvec3 n = dice.direction_around(-cone.axis, 0.75);
  std::vector<dvec3> vertices;
  for (int i = 0; i < corners; ++i) {
    const double phi = -2.0 * kPi * (i + 0.6 * dice.unit()) / corners;
    const dvec3 d = std::cos(cone.angle) * cone.axis + std::sin(cone.angle) * (std::cos(phi) * s + std::sin(phi) * t);
    vertices.push_back(d * (distance * glm::dot(cone.axis, n) / glm::dot(d, n)));
  }
  return vertices;
}

struct LightCounts {
  int polygons = 0, spheres = 0;
  int turned = 0;  ///< polygons that emit the other way
  int hidden = 0;  ///< lights partly behind something
};

/// Adds a polygonal light and returns the irradiance it sends to the origin.
dvec3 add_polygon_light(Scene& scene, Dice& dice, const Cone& cone, const dvec3& radiance, LightCounts& counts) {
  ++counts.polygons;
  std::vector<dvec3> light = polygon_in_cone(dice, cone, dice.between(0.6, 2.5));
  double irradiance = closed_form::polygon_irradiance(light, {0, 1, 0});
  if (dice.chance(0.3)) {  // half of it, or all, is hidden by a smaller copy nearer by
    std::vector<dvec3> blocker(light.begin(), light.begin() + (light.size() + 2) / 2);
    irradiance -= closed_form::polygon_irradiance(blocker, {0, 1, 0});
    for (dvec3& p : blocker) p *= 0.6;
    ++counts.hidden;
    add_shape(scene, polygon_mesh(blocker), DiffuseBsdf{dvec3(0.0)});
  }
  if (dice.chance(0.25)) {  // turned away
    std::reverse(light.begin(), light.end());
    irradiance = 0.0;
    ++counts.turned;
  }
  add_shape(scene, polygon_mesh(light), DiffuseBsdf{dvec3(0.0)}, radiance);
  return irradiance * radiance;
}

dvec3 add_sphere_light(Scene& scene, Dice& dice, const Cone& cone, const dvec3& radiance, LightCounts& counts) {
  ++counts.spheres;
  const double distance = dice.between(0.6, 2.5);
  const Sphere light{distance * cone.axis, distance * std::sin(cone.angle)};
  double irradiance = closed_form::sphere_irradiance(light.center, light.radius, {0, 1, 0});
  if (dice.chance(0.3)) {  // its middle is hidden
    const double near = 0.4 * distance;
    ++counts.hidden;
    const Sphere blocker{near * cone.axis, near * std::sin(0.6 * cone.angle)};
    irradiance -= closed_form::sphere_irradiance(blocker.center, blocker.radius, {0, 1, 0});
    add_shape(scene, blocker, DiffuseBsdf{dvec3(0.0)});
  }
  add_shape(scene, light, DiffuseBsdf{dvec3(0.0)}, radiance);
  return irradiance * radiance;
}

ClosedFormScene direct_scene(Dice& dice, LightStrategy strategy, const Crowd& crowd) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  dvec3 irradiance(0.0);
  double hit_share = 0.0;
  LightCounts counts;
  // Light that chance hardly ever finds would make the naive estimator too skewed for a t-test.
  while (hit_share < 0.05) {
    scene = Scene{};
    irradiance = dvec3(0.0);
    hit_share = 0.0;
    counts = {};
    for (const Cone& cone : disjoint_cones(dice, crowd)) {
      const dvec3 radiance = dice.color(0.2, 4.0);
      const bool sphere = dice.chance(0.4);
      const dvec3 e = sphere ? add_sphere_light(scene, dice, cone, radiance, counts)
                             : add_polygon_light(scene, dice, cone, radiance, counts);
      irradiance += e;
      hit_share += luminance(e / radiance) / kPi;
    }
  }
  const dvec3 albedo = dice.color(0.2, 0.9);
  add_shape(scene, square({1.3, 0, -2.1}, {0, 1, 0}, 10.0), DiffuseBsdf{albedo});
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = 0;
  set_strategy(scene, strategy);
  scene.camera = look_along({0, 0.01, 0}, {0, -1, 0}, kPointFov);
  move_scene(scene, dice, true);
  result.expected = luminance(albedo / kPi * irradiance);
  result.name = fmt::format("direct light, {} polygon(s), {} sphere(s), {} turned away, {} hidden, {}", counts.polygons,
                            counts.spheres, counts.turned, counts.hidden, light_strategy_name(strategy));
  return result;
}

/// So many lights that they are chosen by a tree, in every second scene with Sobol sets.
ClosedFormScene crowd_scene(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result = direct_scene(dice, strategy, kManySmallLights);
  if (dice.chance(0.5)) {
    result.scene.sampler = {.type = Sampler::Type::sobol,
                            .set_bits = static_cast<std::uint32_t>(dice.between_int(1, 6))};
    result.name += fmt::format(", sobol sets of {}", result.scene.sampler.set_size());
  }
  result.name.replace(0, std::string_view("direct light").size(), "crowd");
  return result;
}

// --- furnace and interior

DielectricBsdf random_dielectric(Dice& dice) {
  const double ext_ior = dice.between(1.0, 1.3);
  DielectricBsdf glass{ext_ior * dice.between(1.25, 2.0), ext_ior};
  if (dice.chance(0.3)) std::swap(glass.int_ior, glass.ext_ior);
  return glass;
}

/// Share of the even light around a dielectric sphere that reaches a camera outside within `depth` segments: the rays
/// that stay inside longer are missing. Every inner hit has the reflectance of the first.
double sphere_throughput(double reflectance, std::uint32_t depth) {
  return reflectance + (1.0 - reflectance) * (1.0 - std::pow(reflectance, static_cast<double>(depth) - 2.0));
}

/// A path length at which what is cut off is either nothing or found often enough to be tested: an event of probability
/// 1e-4 that no sample saw would look like an error. The share lost at depth N is reflectance^(N − `first_lost`).
std::uint32_t depth_for(Dice& dice, double reflectance, std::uint32_t first_lost) {
  const auto depth = static_cast<std::uint32_t>(dice.between_int(2, 5));
  const double lost = std::pow(reflectance, static_cast<double>(depth - first_lost));
  return lost > 0.01 && lost < 0.99 ? depth : 64;
}

ClosedFormScene interior_scene(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 half = dice.color(0.8, 1.2), radiance = dice.color(0.2, 2.0);
  add_shape(scene, inward_box(half), DiffuseBsdf{dvec3(0.0)}, radiance);
  const Sphere sphere{dice.color(-0.2, 0.2), 0.3};
  const dvec3 n = dice.direction();
  const dvec3 point = sphere.center + sphere.radius * n, wo = dice.direction_around(n, 0.2);
  scene.integrator.max_depth = static_cast<std::uint32_t>(dice.between_int(2, 8));
  scene.integrator.rr_depth = static_cast<std::uint32_t>(dice.chance(0.5) ? 0 : 1);
  set_strategy(scene, strategy);
  scene.camera = look_along(point + 0.2 * wo, -wo, kPointFov);
  dvec3 reflectance(1.0);
  const char* material = "mirror";
  switch (dice.below(3)) {
    case 0:
      reflectance = dice.color(0.2, 0.9);
      add_shape(scene, sphere, DiffuseBsdf{reflectance});
      material = "diffuse";
      break;
    case 1:
      add_shape(scene, sphere, MirrorBsdf{});
      break;
    default: {
      const DielectricBsdf glass = random_dielectric(dice);
      const double f = closed_form::fresnel_reflectance(glm::dot(n, wo), glass.ext_ior, glass.int_ior);
      scene.integrator.max_depth = depth_for(dice, f, 2);
      reflectance = dvec3(sphere_throughput(f, scene.integrator.max_depth));
      add_shape(scene, sphere, glass);
      material = "dielectric";
    }
  }
  move_scene(scene, dice, true);
  result.expected = luminance(reflectance * radiance);
  result.name = fmt::format("{} sphere in an emitting box, depth {}, {}", material, scene.integrator.max_depth,
                            light_strategy_name(strategy));
  return result;
}

// --- under the sky

Sky random_sky(Dice& dice) {
  return {.top = dice.color(0.5, 3.0), .horizon = dice.color(0.1, 1.0)};
}

ClosedFormScene sky_scene(Dice& dice, LightStrategy strategy) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  scene.sky = random_sky(dice);
  const bool sphere = dice.chance(0.5), mirror = dice.chance(0.5);
  const dvec3 n = dice.direction(), wo = dice.direction_around(n, 0.2), albedo = dice.color(0.2, 0.9);
  const Bsdf bsdf = mirror ? Bsdf(MirrorBsdf{}) : Bsdf(DiffuseBsdf{albedo});
  add_shape(scene, sphere ? Shape(Sphere{-0.7 * n, 0.7}) : Shape(square(dvec3(0.0), n, 1.0)), bsdf);
  scene.integrator.max_depth = static_cast<std::uint32_t>(dice.between_int(2, 5));
  scene.integrator.rr_depth = static_cast<std::uint32_t>(dice.chance(0.5) ? 0 : 1);
  scene.camera = look_along(0.5 * wo, -wo, kPointFov);
  move_scene(scene, dice, false);
  const dvec3 gradient = scene.sky.top - scene.sky.horizon;
  const dvec3 diffuse =
      albedo * (scene.sky.horizon + gradient * (closed_form::clamped_cosine_product(n, {0, 1, 0}) / kPi));
  result.expected = luminance(mirror ? sky_radiance(scene.sky, reflect_about(wo, n)) : diffuse);
  set_strategy(scene, strategy);
  result.name = fmt::format("{} {} under the sky, {}", mirror ? "mirroring" : "diffuse", sphere ? "sphere" : "square",
                            light_strategy_name(strategy));
  return result;
}

/// True where rounding could decide whether light is reflected totally.
bool near_critical_angle(double cos_o, double n_o, double n_t) {
  const double sin_t = n_o / n_t * std::sqrt(1.0 - cos_o * cos_o);
  return sin_t > 0.97 && sin_t < 1.03;
}

ClosedFormScene sheet_scene(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  scene.sky = random_sky(dice);
  const DielectricBsdf glass = random_dielectric(dice);
  const bool outside = dice.chance(0.5);
  const double n_o = outside ? glass.ext_ior : glass.int_ior, n_t = outside ? glass.int_ior : glass.ext_ior;
  const dvec3 n = dice.direction();  // on the camera's side
  dvec3 wo = dice.direction_around(n, 0.2);
  while (near_critical_angle(glm::dot(wo, n), n_o, n_t)) wo = dice.direction_around(n, 0.2);
  add_shape(scene, square({0.3 * tangents(n).first}, outside ? n : -n, 1.0), glass);
  scene.integrator.max_depth = 2;
  scene.integrator.rr_depth = static_cast<std::uint32_t>(dice.chance(0.5) ? 0 : 1);
  scene.camera = look_along(0.5 * wo, -wo, kPointFov);
  move_scene(scene, dice, false);
  const double f = closed_form::fresnel_reflectance(glm::dot(wo, n), n_o, n_t), ratio = n_o / n_t;
  dvec3 radiance = f * sky_radiance(scene.sky, reflect_about(wo, n));
  if (f < 1.0) {
    const dvec3 across = -ratio * (wo - glm::dot(wo, n) * n);
    const dvec3 wt = across - std::sqrt(1.0 - glm::dot(across, across)) * n;
    radiance += (1.0 - f) * ratio * ratio * sky_radiance(scene.sky, wt);
  }
  result.expected = luminance(radiance);
  result.name = fmt::format("{} sheet from {}, {:.3g} to {:.3g}", f < 1.0 ? "refracting" : "totally reflecting",
                            outside ? "outside" : "inside", n_o, n_t);
  return result;
}

ClosedFormScene glass_scene(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 radiance = dice.color(0.2, 2.0);
  scene.sky = {.top = radiance, .horizon = radiance};
  const DielectricBsdf glass = random_dielectric(dice);
  const bool inside = dice.chance(0.6);
  const double n_o = inside ? glass.int_ior : glass.ext_ior, n_t = inside ? glass.ext_ior : glass.int_ior;
  scene.integrator.rr_depth = static_cast<std::uint32_t>(dice.chance(0.5) ? 0 : 1);
  const dvec3 n = dice.direction();
  dvec3 wo = dice.direction_around(n, 0.2);
  while (near_critical_angle(glm::dot(wo, n), n_o, n_t)) wo = dice.direction_around(n, 0.2);
  // The camera looks at the origin; the sphere is on the far side of it, or around the camera.
  add_shape(scene, Sphere{inside ? n : -n, 1.0}, glass);
  scene.camera = look_along((inside ? 0.3 : 1.0) * wo, -wo, kPointFov);
  move_scene(scene, dice, true);
  const double f = closed_form::fresnel_reflectance(glm::dot(wo, n), n_o, n_t), ratio = n_o / n_t;
  const std::uint32_t depth = scene.integrator.max_depth = depth_for(dice, f, inside ? 1 : 2);
  const double share =
      inside ? (f < 1.0 ? ratio * ratio * (1.0 - std::pow(f, depth - 1.0)) : 0.0) : sphere_throughput(f, depth);
  result.expected = luminance(share * radiance);
  result.name =
      fmt::format("{} sphere from {}, {:.3g} to {:.3g}, depth {}", f < 1.0 ? "refracting" : "totally reflecting",
                  inside ? "inside" : "outside", n_o, n_t, depth);
  return result;
}

// --- coverage

}  // namespace

ClosedFormScene closed_form::furnace_scene(Dice& dice, LightStrategy strategy) {
  // Sampling the light alone has unbounded variance near the edges of a box that emits all over.
  if (strategy == LightStrategy::nee) strategy = LightStrategy::mis;
  ClosedFormScene result;
  Scene& scene = result.scene;
  const dvec3 half = dice.color(0.3, 1.0), albedo = dice.color(0.3, 0.9), radiance = dice.color(0.2, 2.0);
  add_shape(scene, inward_box(half), DiffuseBsdf{albedo}, radiance);
  scene.integrator.max_depth = static_cast<std::uint32_t>(dice.between_int(1, 10));
  scene.integrator.rr_depth = static_cast<std::uint32_t>(dice.chance(0.25) ? 0 : dice.between_int(2, 4));
  set_strategy(scene, strategy);
  scene.camera = look_along(half * dice.color(-0.8, 0.8), dice.direction(), 90.0);
  move_scene(scene, dice, true);
  dvec3 sum(0.0), power(1.0);
  for (std::uint32_t i = 0; i < scene.integrator.max_depth; ++i) {
    sum += power;
    power *= albedo;
  }
  result.expected = luminance(sum * radiance);
  result.name = fmt::format("furnace, depth {}, roulette {}, {}", scene.integrator.max_depth, scene.integrator.rr_depth,
                            light_strategy_name(strategy));
  return result;
}

ClosedFormScene closed_form::coverage_scene(Dice& dice) {
  ClosedFormScene result;
  Scene& scene = result.scene;
  Camera& camera = scene.camera;
  camera = look_along(dice.color(-1.0, 1.0), dice.direction(), dice.between(15.0, 70.0));
  camera.filter = random_filter(dice);
  if (dice.chance(0.5)) camera.world_from_camera[0] *= -1.0;  // a mirrored camera
  const auto share = [&](double from, double to) {
    return closed_form::filter_share(camera.filter, to) - closed_form::filter_share(camera.filter, from);
  };
  // Film positions of the rectangle's sides, in pixels from the centre of the only pixel. It must be missed, and hit,
  // often enough.
  double x0 = 0.0, x1 = 0.0, y0 = 0.0, y1 = 0.0, covered = 0.0;
  while (covered < 0.05 || covered > 0.95) {
    x0 = dice.between(-1.0, 0.1), x1 = dice.between(0.15, 1.2);
    y0 = dice.between(-1.2, 0.0), y1 = dice.between(0.1, 1.0);
    covered = share(x0, x1) * share(y0, y1);
  }
  const double slope = 2.0 * std::tan(camera.fov * kPi / 360.0), depth = dice.between(0.5, 5.0);
  std::vector<dvec3> corners;
  for (const glm::dvec2& film : {glm::dvec2(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}}) {
    corners.emplace_back(camera.world_from_camera *
                         glm::dvec4(-slope * film.x * depth, -slope * film.y * depth, depth, 1.0));
  }
  const dvec3 forward(camera.world_from_camera[2]);
  if (glm::dot(glm::cross(corners[1] - corners[0], corners[2] - corners[0]), forward) > 0.0)
    std::reverse(corners.begin(), corners.end());
  const dvec3 radiance = dice.color(0.2, 2.0);
  add_shape(scene, polygon_mesh(corners), DiffuseBsdf{dvec3(0.5)}, radiance);
  scene.integrator.max_depth = 1;
  move_scene(scene, dice, true);
  result.expected = covered * luminance(radiance);
  constexpr std::array<const char*, 5> kNames{"box", "tent", "gaussian", "mitchell", "lanczos"};
  result.name = fmt::format("rectangle in a pixel, {} filter", kNames[static_cast<std::size_t>(camera.filter.type)]);
  return result;
}

ClosedFormScene closed_form::direct_light_scene(Dice& dice, LightStrategy strategy) {
  return direct_scene(dice, strategy, kFewLights);
}

const char* scene_family_name(SceneFamily family) {
  constexpr std::array<const char*, kSceneFamilies.size()> kNames{
      "direct", "furnace",    "interior",    "sky",     "sheet", "glass",   "coverage", "crowd",
      "camera", "integrator", "environment", "texture", "delta", "adapter", "aov"};
  return kNames[static_cast<std::size_t>(family)];
}

const char* light_strategy_name(LightStrategy strategy) {
  static constexpr const char* kNames[] = {"naive", "nee", "mis"};
  return kNames[static_cast<std::size_t>(strategy)];
}

ClosedFormScene make_closed_form(SceneFamily family, std::uint64_t seed, LightStrategy strategy) {
  // The number of the original families, so that their scenes keep their numbers.
  constexpr std::uint64_t kStreams = 7;
  const auto number = static_cast<std::uint64_t>(family);
  Dice dice(number < kStreams ? seed * kStreams + number : ~(seed * kStreams + number));
  ClosedFormScene result = [&] {
    switch (family) {
      case SceneFamily::direct:
        return direct_scene(dice, strategy, kFewLights);
      case SceneFamily::crowd:
        return crowd_scene(dice, strategy);
      case SceneFamily::furnace:
        return furnace_scene(dice, strategy);
      case SceneFamily::interior:
        return interior_scene(dice, strategy);
      case SceneFamily::sky:
        return sky_scene(dice, strategy);
      case SceneFamily::sheet:
        return sheet_scene(dice);
      case SceneFamily::glass:
        return glass_scene(dice);
      case SceneFamily::texture:
        return texture_scene(dice, strategy);
      case SceneFamily::adapter:
        return adapter_scene(dice, strategy);
      case SceneFamily::aov:
        return aov_scene(dice, strategy);
      case SceneFamily::camera:
        return camera_scene(dice);
      case SceneFamily::integrator:
        return integrator_scene(dice, strategy);
      case SceneFamily::environment:
        return environment_scene(dice, strategy);
      case SceneFamily::delta:
        return delta_scene(dice, strategy);
      case SceneFamily::coverage:
        break;
    }
    return coverage_scene(dice);
  }();
  result.scene.name = result.scene.file = fmt::format("{}-{}", scene_family_name(family), seed);
  return result;
}

ClosedFormScene make_closed_form(SceneFamily family, std::uint64_t seed) {
  Dice dice(~seed);
  return make_closed_form(family, seed, static_cast<LightStrategy>(dice.below(3)));
}

}  // namespace etendue
