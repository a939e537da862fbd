#include "bench/scene_bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

#include <fmt/core.h>

#include "compile/normalization.h"
#include "gpu/ray_caster.h"
#include "reference/ray_caster.h"
#include "reference/reference_renderer.h"
#include "render/film_identity.h"
#include "vulkan/buffer.h"

namespace etendue {
namespace {

constexpr double kCastSeconds = 0.05;  // rays are cast again until they have taken this long

Placement place(const Scene& scene) {
  const Normalization n = find_normalization(scene);
  return {n.center, n.scale};
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string settings_of(const Scene& scene) {
  const Integrator& i = scene.integrator;
  if (i.type != Integrator::Type::path) return integrator_text(scene);
  return fmt::format("path maxDepth={} nee={} mis={} rrDepth={}", i.max_depth, i.nee, i.mis, i.rr_depth);
}

// CPU time of this process, all its threads together: a CPU driver's are among them.
double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

template <typename Row>
std::vector<double> column(const std::vector<Row>& rows, double Row::*member) {
  std::vector<double> out;
  out.reserve(rows.size());
  for (const Row& row : rows) out.push_back(row.*member);
  return out;
}

}  // namespace

bool SceneReport::passed() const {
  return std::ranges::all_of(rays, [](const RayRates& r) { return !r.check || r.check->passed(); });
}

SceneBench::SceneBench(Scene scene, const BenchOptions& options) : scene_(std::move(scene)), options_(options) {}
SceneBench::~SceneBench() = default;

Placement SceneBench::placement() const {
  return place(scene_);
}

void SceneBench::repeat_start_up() {
  if (!options_.start_up || !options_.gpu) return;
  cold_.push_back(measure_start_up(scene_, *options_.gpu, true));
  // The first one with caches fills them.
  if (warm_.empty()) measure_start_up(scene_, *options_.gpu, false);
  warm_.push_back(measure_start_up(scene_, *options_.gpu, false));
}

void SceneBench::read_kernels() {
  if (!options_.compiler || !options_.gpu) return;
  const std::unique_ptr<Renderer> renderer = make_gpu_renderer(shared_, {.seed = options_.seed}, *options_.gpu);
  device_name_ = renderer->device_name();
  driver_name_ = renderer->driver_name();
  vulkan::ContextOptions how = options_.gpu->context;
  how.requirements.ray_queries = options_.gpu->queries();
  how.kernel_statistics = true;
  const vulkan::Context compiler(*options_.compiler, how);
  compiler_ = fmt::format("{}, {}", compiler.info().name, compiler.info().driver);
  kernels_ = gpu_kernels(*renderer, compiler);
}

void SceneBench::open() {
  if (options_.cast_rays) open_caster();
  if (options_.render) open_renderer();
}

void SceneBench::open_caster() {
  const auto reference = [&] { return make_reference_ray_caster(scene_, placement()); };
  caster_ = options_.gpu ? make_gpu_ray_caster(shared_, *options_.gpu) : reference();
  device_name_ = caster_->device_name();
  driver_name_ = caster_->driver_name();
  sets_ = make_ray_sets(scene_, *caster_,
                        {.count = options_.rays > 0 ? options_.rays : caster_->enough_rays(), .seed = options_.seed});
  const std::unique_ptr<RayCaster> judge = options_.gpu && options_.checked_rays > 0 ? reference() : nullptr;
  for (const RaySet& set : sets_) {
    caster_->load(set.rays);
    caster_->cast(set.query);  // the first one warms up
    hits_.push_back(caster_->hits());
    RayRates rates{.kind = set.kind, .shuffled = set.shuffled, .count = set.rays.size()};
    for (const CastHit& hit : hits_.back()) {
      rates.hits += hit.instance != CastHit::kNone;
      rates.steps += static_cast<double>(hit.steps) / static_cast<double>(set.rays.size());
    }
    if (judge) rates.check = check_rays(set, hits_.back(), *judge, options_.checked_rays);
    rates_.push_back(rates);
  }
  ray_paces_.resize(sets_.size());
}

void SceneBench::open_renderer() {
  const vulkan::MemoryUse before = vulkan::memory_use();
  vulkan::reset_memory_peak();
  const RenderSettings settings{.seed = options_.seed};
  renderer_ =
      options_.gpu ? make_gpu_renderer(shared_, settings, *options_.gpu) : make_reference_renderer(scene_, settings);
  device_name_ = renderer_->device_name();
  driver_name_ = renderer_->driver_name();
  // The first sample pays for the kernel, the next ones show how many fit into a repetition.
  render(1);
  double seconds = render(1);
  spp_ = options_.spp > 0 ? static_cast<std::uint32_t>(scene_.sampler.sets_of(options_.spp)) : spp_for(seconds);
  device_peak_ = vulkan::memory_use().peak - before.now;
}

// As many samples as take about the wanted time; `seconds` is what one took.
std::uint32_t SceneBench::spp_for(double seconds) {
  while (seconds < 0.25 * options_.seconds) {
    const double more = std::clamp(0.5 * options_.seconds / std::max(seconds, 1e-6), 2.0, 16.0);
    spp_ = static_cast<std::uint32_t>(std::min(spp_ * more, 65536.0));
    seconds = render(spp_);
    if (spp_ == 65536) break;
  }
  return static_cast<std::uint32_t>(
      std::clamp(std::round(spp_ * options_.seconds / std::max(seconds, 1e-6)), 1.0, 65536.0));
}

// Returns the seconds the device, or the reference, computed.
double SceneBench::render(std::uint32_t spp) {
  // Sample indices start over long before their 32 bits end; which samples are timed does not matter.
  if (next_sample_ > 0x7fffffffu) next_sample_ = 0;
  const SampleRange range{next_sample_, next_sample_ + spp};
  next_sample_ = range.end;
  Film film(scene_.camera.width, scene_.camera.height, film_exponent(scene_));
  std::vector<RejectedSample> rejected;
  const double before = options_.gpu ? gpu_timings(*renderer_).render : 0.0;
  const auto start = std::chrono::steady_clock::now();
  renderer_->render(range, film, {}, rejected);
  return options_.gpu ? gpu_timings(*renderer_).render - before : seconds_since(start);
}

void SceneBench::repeat() {
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    caster_->load(sets_[i].rays);
    double seconds = 0.0, rays = 0.0;
    const double cpu_start = cpu_seconds();
    do {
      seconds += caster_->cast(sets_[i].query);
      rays += static_cast<double>(sets_[i].rays.size());
    } while (seconds < kCastSeconds);
    ray_paces_[i].push_back({rays / seconds, rays / (cpu_seconds() - cpu_start)});
  }
  if (!renderer_) return;
  const double samples =
      static_cast<double>(spp_) * scene_.sampler.set_size() * scene_.camera.width * scene_.camera.height;
  const double cpu_start = cpu_seconds(), seconds = render(spp_);
  sample_paces_.push_back({samples / seconds, samples / (cpu_seconds() - cpu_start)});
}

SceneReport SceneBench::report() const {
  SceneReport out{.name = scene_.name,
                  .file = scene_.file,
                  .integrator = settings_of(scene_),
                  .width = scene_.camera.width,
                  .height = scene_.camera.height};
  for (const Instance& instance : scene_.instances) {
    const Shape& shape = scene_.shape_of(instance);
    (std::holds_alternative<Sphere>(shape) ? out.spheres : out.triangles) += primitive_count(shape);
  }
  std::vector<StartUp> all = cold_;
  all.insert(all.end(), warm_.begin(), warm_.end());
  out.compile = spread_of(column(all, &StartUp::compile));
  out.upload = spread_of(column(all, &StartUp::upload));
  out.pipeline_cold = spread_of(column(cold_, &StartUp::pipeline));
  out.pipeline_warm = spread_of(column(warm_, &StartUp::pipeline));
  for (const StartUp& s : all) {
    if (s.host_peak) out.host_peak = std::max(out.host_peak.value_or(0), *s.host_peak);
  }
  out.device_peak = device_peak_;
  out.compiler = compiler_;
  out.kernels = kernels_;
  out.rays = rates_;
  for (std::size_t i = 0; i < rates_.size(); ++i) {
    out.rays[i].rate = spread_of(column(ray_paces_[i], &Pace::wall));
    out.rays[i].cpu_rate = spread_of(column(ray_paces_[i], &Pace::cpu));
  }
  out.sample_rate = spread_of(column(sample_paces_, &Pace::wall));
  out.cpu_sample_rate = spread_of(column(sample_paces_, &Pace::cpu));
  out.repeated_spp = spp_ * scene_.sampler.set_size();
  return out;
}

}  // namespace etendue
