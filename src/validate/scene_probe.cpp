#include "validate/scene_probe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "compile/overlap.h"
#include "core/text.h"
#include "reference/ray_caster.h"
#include "reference/reference_renderer.h"
#include "scene/sharing.h"

namespace etendue {
namespace {

constexpr std::uint32_t kSide = 64;      // pixels of the longer side
constexpr std::uint32_t kMaxDepth = 32;  // bounds paths that would go on for ever
constexpr std::uint64_t kOftenTried = 256;

/// How often paths tried to reach an emitter, and did.
struct EmitterCount {
  std::uint64_t tried = 0, reached = 0;
};

struct Counts {
  std::uint64_t paths = 0, seen = 0, lit = 0;
  std::vector<EmitterCount> emitters;  ///< by instance
};

std::size_t placed_primitives(const Scene& scene) {
  const Sharing sharing(scene);
  std::size_t count = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    count += sharing.has_instance(i) ? 1 : primitive_count(scene.shape_of(scene.instances[i]));
  return count;
}

/// The same view on few pixels.
void shrink_film(Camera& camera) {
  const double longer = std::max(camera.width, camera.height);
  const auto side = [&](std::uint32_t pixels) {
    return static_cast<std::uint32_t>(std::clamp(kSide * pixels / longer, 1.0, double{kSide}));
  };
  camera.width = side(camera.width);
  camera.height = side(camera.height);
}

void count_path(const std::vector<PathVertex>& path, Counts& counts) {
  ++counts.paths;
  if (path.empty()) return;
  if (path.front().instance != PathVertex::kNone) ++counts.seen;
  if (path.back().radiance != glm::vec3(0.0f)) ++counts.lit;
  glm::vec3 before(0.0f);
  for (const PathVertex& vertex : path) {
    // Light that is there without a light sample having brought it was met by chance.
    const bool sampled = vertex.light_instance != PathVertex::kNone;
    if (sampled && vertex.light_instance < counts.emitters.size()) {
      EmitterCount& emitter = counts.emitters[vertex.light_instance];
      ++emitter.tried;
      if (vertex.light_contributed == 1) ++emitter.reached;
    }
    if (vertex.instance != PathVertex::kNone && vertex.radiance != before) ++counts.emitters[vertex.instance].reached;
    before = vertex.radiance;
  }
}

Counts count_paths(const Scene& scene) {
  const std::unique_ptr<Renderer> renderer = make_reference_renderer(scene, RenderSettings{.seed = 1});
  Counts counts;
  counts.emitters.resize(scene.instances.size());
  const std::uint32_t pixels = scene.camera.width * scene.camera.height;
  for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) count_path(renderer->trace_path({pixel, 0}), counts);
  return counts;
}

void warn_emitters(const Scene& scene, const Counts& counts, Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const EmitterCount& count = counts.emitters[i];
    if (count.tried < kOftenTried || count.reached > 0) continue;
    diagnostics.warning(
        scene.instances[i].position,
        fmt::format(
            "the emitter {} was tried {} times and never reached: something blocks it, or it faces the other way",
            text::quoted(scene.instances[i].name), count.tried));
  }
}

// A CPU device ends a path after 60 000 loop iterations. A box that a ray meets costs one and a half of them, nodes and
// idle lanes included, and the ray that goes on from there often meets as many. (Measured: a fan of 70 000 triangles
// with 11 667 boxes at the fullest of our places does not render, one of a third does.)
constexpr std::size_t kTooManyAlong = 20000, kTooManyAt = 10000;
constexpr std::size_t kManyAlong = 4000, kManyAt = 2000;  ///< long paths may not fit

/// The camera ray through the middle of cell (x, y) of 8 × 8, from world space's origin of the camera; not unit length.
constexpr std::uint32_t kRaysAcross = 8;
glm::dvec3 ray_direction(const Camera& camera, std::uint32_t x, std::uint32_t y) {
  const double tan_x = std::tan(glm::radians(0.5 * camera.fov)), tan_y = tan_x * camera.height / camera.width;
  const auto place = [](std::uint32_t i) { return 1.0 - (2.0 * i + 1.0) / kRaysAcross; };
  return glm::dmat3(camera.world_from_camera) * glm::dvec3(tan_x * place(x), tan_y * place(y), 1.0);
}

/// Boxes along the most crowded of 64 camera rays, up to what they hit.
std::size_t count_along_camera_rays(const Scene& scene, const Crowding& crowding) {
  const glm::dvec3 origin(scene.camera.world_from_camera[3]);
  std::unique_ptr<RayCaster> caster;  // made only when it matters what is hidden
  std::size_t most = 0;
  for (std::uint32_t i = 0; i < kRaysAcross * kRaysAcross; ++i) {
    const glm::dvec3 d = ray_direction(scene.camera, i % kRaysAcross, i / kRaysAcross);
    const std::size_t all = crowding.count_along(origin, d, std::numeric_limits<double>::infinity());
    if (all <= std::max(most, kManyAlong)) continue;
    if (!caster) caster = make_reference_ray_caster(scene, {});
    const CastRay ray{.o = glm::vec3(origin), .d = glm::vec3(glm::normalize(d)), .t_max = INFINITY};
    caster->load(std::span(&ray, 1));
    caster->cast(RayQuery::closest);
    const CastHit hit = caster->hits().front();
    const double end = hit.instance == CastHit::kNone ? INFINITY : hit.t / glm::length(d);
    most = std::max(most, crowding.count_along(origin, d, end));
  }
  return most;
}

void report_crowd(const SourcePosition& position, const std::string& what, bool too_many, Diagnostics& diagnostics) {
  if (too_many) {
    diagnostics.error(position, what + "more than a device can handle; thin them out, or use --device reference");
  } else {
    diagnostics.warning(position, what + "which is slow, and long paths may end in an error; no paths were tried");
  }
}

/// Reports where too many primitives overlap. Paths there would take long here, too.
bool is_crowded(const Scene& scene, Diagnostics& diagnostics) {
  if (placed_primitives(scene) <= kManyAt) return false;
  const Crowding crowding(scene);
  if (crowding.primitives() <= kManyAt) return false;
  const auto place = crowding.find_place();
  if (place && place->count > kManyAt) {
    const Instance& instance = scene.instances[place->instance];
    report_crowd(
        instance.position,
        fmt::format("{} triangles or spheres overlap at {:.6g} {:.6g} {:.6g}, {} among them: a ray there has to "
                    "test them all, ",
                    place->count, place->at.x, place->at.y, place->at.z, text::quoted(instance.name)),
        place->count > kTooManyAt, diagnostics);
    return true;
  }
  const std::size_t along = count_along_camera_rays(scene, crowding);
  if (along <= kManyAlong) return false;
  report_crowd(
      scene.position,
      fmt::format(
          "a camera ray meets the boxes of {} triangles or spheres before it hits one, and has to test them all, ",
          along),
      along > kTooManyAlong, diagnostics);
  return true;
}

}  // namespace

void probe_scene(Scene scene, Diagnostics& diagnostics) {
  if (scene.instances.empty()) {
    diagnostics.warning(scene.position, "the scene has no mesh; the picture shows its sky only");
    return;
  }
  if (const std::size_t count = placed_primitives(scene); count > kMaxProbedPrimitives) {
    diagnostics.note(scene.position, fmt::format("no paths were tried: the scene has {} primitives, more than {}",
                                                 count, kMaxProbedPrimitives));
    return;
  }
  if (is_crowded(scene, diagnostics)) return;
  shrink_film(scene.camera);
  scene.integrator.max_depth = std::min(scene.integrator.max_depth, kMaxDepth);
  const bool path_tracing = gathers_light(scene.integrator);
  const Counts counts = count_paths(scene);
  if (counts.seen == 0) {
    diagnostics.warning(
        scene.camera.position,
        fmt::format(
            "none of {} camera rays meets a mesh: turn the camera toward the scene, or check its clipping planes",
            counts.paths));
    return;
  }
  const bool has_emitter = std::ranges::any_of(scene.instances, [&](const Instance& instance) {
    const AreaEmitter* emitter = scene.emitter_of(instance);
    return emitter != nullptr && emitter->radiance.value != glm::dvec3(0.0);
  });
  const bool has_sky = !is_dark(scene.sky);
  if (!path_tracing || (!has_emitter && !has_sky)) return;
  if (counts.lit == 0) {
    diagnostics.warning(scene.position,
                        fmt::format("none of {} paths finds light: what the camera sees is black", counts.paths));
    return;
  }
  warn_emitters(scene, counts, diagnostics);
}

}  // namespace etendue
