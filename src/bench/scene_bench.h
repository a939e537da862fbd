#pragma once
/// Everything that is measured of one scene, one repetition at a time, so that scenes can take turns: the speed of
/// shared machines drifts, and what is compared should share the drift.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/ray_check.h"
#include "bench/ray_sets.h"
#include "bench/spread.h"
#include "bench/start_up.h"
#include "gpu/gpu_renderer.h"

namespace etendue {

struct BenchOptions {
  std::optional<GpuOptions> gpu;       ///< nothing: the reference
  std::size_t rays = 0;                ///< primary rays; 0: as many as suit the device
  double seconds = 1.0;                ///< of samples in one repetition, about
  std::uint32_t spp = 0;               ///< samples per pixel of one repetition instead; 0: as many as take so long
  std::size_t checked_rays = 1 << 15;  ///< of each set, compared with the reference
  std::uint32_t seed = 0;
  bool start_up = true, cast_rays = true, render = true;  ///< what is measured
  std::optional<std::string> compiler;                    ///< the device whose driver is asked for kernel statistics
};

struct RayRates {
  std::string kind;  ///< see RaySet
  bool shuffled = false;
  std::size_t count = 0;  ///< rays in a cast
  std::size_t hits = 0;
  double steps = 0;  ///< mean records of the tree visited by a ray; 0: not counted
  Spread rate;       ///< rays/s
  Spread cpu_rate;  ///< rays per second of CPU time, all threads together; steadier where a CPU driver shares its cores
  std::optional<RayCheck> check;
};

struct SceneReport {
  std::string name, file, integrator;
  std::uint32_t width = 0, height = 0;
  std::size_t triangles = 0, spheres = 0;
  Spread compile, upload, pipeline_cold, pipeline_warm;  ///< seconds; see StartUp
  std::optional<std::uint64_t> host_peak;                ///< bytes; see StartUp
  std::uint64_t device_peak = 0;                         ///< bytes of Vulkan buffers of a renderer with the whole film
  std::string compiler;                                  ///< device and driver that `kernels` are from
  std::vector<KernelReport> kernels;                     ///< empty if not asked for
  std::vector<RayRates> rays;
  Spread sample_rate;              ///< pixel samples/s, transfers of the film left out
  Spread cpu_sample_rate;          ///< pixel samples per second of CPU time, all threads together
  std::uint32_t repeated_spp = 0;  ///< samples of each pixel in one repetition
  /// False when rays hit something else than in the reference, and rounding does not explain it.
  bool passed() const;
};

class SceneBench {
 public:
  SceneBench(Scene scene, const BenchOptions& options);
  ~SceneBench();

  /// Phase 1, before any open(): start-up costs, with no other device open.
  void repeat_start_up();
  /// Likewise: asks the driver's compiler.
  void read_kernels();
  /// Phase 2: opens the device, makes and checks the rays, warms up.
  void open();
  void repeat();

  const Scene& scene() const { return scene_; }
  const std::vector<RaySet>& ray_sets() const { return sets_; }
  /// Answers of each set, as they were checked.
  const std::vector<std::vector<CastHit>>& hits() const { return hits_; }
  Placement placement() const;
  std::string device_name() const { return device_name_; }
  std::string driver_name() const { return driver_name_; }
  SceneReport report() const;

 private:
  /// Rates per second of wall-clock time and per second of CPU time.
  struct Pace {
    double wall = 0, cpu = 0;
  };

  void open_caster();
  void open_renderer();
  std::uint32_t spp_for(double seconds);
  double render(std::uint32_t spp);

  Scene scene_;
  SharedScene shared_{scene_};  // the rays and the renderer share what is compiled
  BenchOptions options_;
  std::string device_name_, driver_name_;
  std::unique_ptr<RayCaster> caster_;
  std::vector<RaySet> sets_;
  std::vector<std::vector<CastHit>> hits_;
  std::vector<RayRates> rates_;
  std::vector<std::vector<Pace>> ray_paces_;  // one list a set
  std::unique_ptr<Renderer> renderer_;
  std::uint32_t spp_ = 1, next_sample_ = 0;
  std::uint64_t device_peak_ = 0;
  std::vector<Pace> sample_paces_;
  std::vector<StartUp> cold_, warm_;
  std::string compiler_;
  std::vector<KernelReport> kernels_;
};

}  // namespace etendue
