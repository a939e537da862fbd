#include "validate/scene_probe.h"

#include <algorithm>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "reference/reference_renderer.h"

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
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) count += primitive_count(scene.shape_of(instance));
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
    if (sampled) {
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
    diagnostics.warning(scene.instances[i].position,
                        fmt::format("the emitter \"{}\" was tried {} times and never reached: something stands before "
                                    "it, or it shines the other way",
                                    scene.instances[i].name, count.tried));
  }
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
  shrink_film(scene.camera);
  scene.integrator.max_depth = std::min(scene.integrator.max_depth, kMaxDepth);
  const bool path_tracing = scene.integrator.type == Integrator::Type::path;
  const Counts counts = count_paths(scene);
  if (counts.seen == 0) {
    diagnostics.warning(scene.camera.position,
                        fmt::format("none of {} camera rays meets a mesh: turn the camera toward the scene, or look at "
                                    "nearClip and farClip",
                                    counts.paths));
    return;
  }
  const bool has_emitter = std::ranges::any_of(scene.instances, [&](const Instance& instance) {
    const AreaEmitter* emitter = scene.emitter_of(instance);
    return emitter != nullptr && emitter->radiance != glm::dvec3(0.0);
  });
  const bool has_sky = scene.sky.top != glm::dvec3(0.0) || scene.sky.horizon != glm::dvec3(0.0);
  if (!path_tracing || (!has_emitter && !has_sky)) return;
  if (counts.lit == 0) {
    diagnostics.warning(scene.position,
                        fmt::format("none of {} paths finds light: what the camera sees is black", counts.paths));
    return;
  }
  warn_emitters(scene, counts, diagnostics);
}

}  // namespace etendue
