#include "reference/reference_renderer.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "core/version.h"
#include "reference/camera.h"
#include "reference/integrator.h"
#include "scene/invariants.h"
#include "scene/material_numbers.h"

namespace etendue {
namespace {

using namespace reference;

constexpr std::size_t kMaxListedRejections = 64;

/// Some rows of pixels × some sample indices: the unit of work of one thread.
struct Block {
  std::uint64_t first_pixel, end_pixel;
  SampleRange samples;
};

/// Cuts width · height pixels × a sample range into blocks. Rows stay together; a film of few pixels is cut along its
/// samples instead, so that a single pixel keeps all threads busy.
class BlockGrid {
 public:
  BlockGrid(const Film& film, SampleRange range) : range_(range), pixels_(film.pixels().size()) {
    // About 20 ms of work: small enough to balance the threads, large enough that merging costs nothing.
    constexpr std::uint64_t kBlockSamples = 8192;
    const std::uint64_t rows = std::max<std::uint64_t>(1, kBlockSamples / film.width());
    block_pixels_ = std::min(rows * film.width(), pixels_);
    block_samples_ = std::max<std::uint64_t>(1, kBlockSamples / block_pixels_);
    columns_ = (pixels_ + block_pixels_ - 1) / block_pixels_;
    layers_ = (range.count() + block_samples_ - 1) / block_samples_;
  }
  std::uint64_t size() const { return columns_ * layers_; }
  Block block(std::uint64_t index) const {
    const std::uint64_t pixel = index % columns_ * block_pixels_;
    const std::uint64_t sample = range_.begin + index / columns_ * block_samples_;
    return {pixel,
            std::min(pixel + block_pixels_, pixels_),
            {static_cast<std::uint32_t>(sample),
             static_cast<std::uint32_t>(std::min<std::uint64_t>(sample + block_samples_, range_.end))}};
  }

 private:
  SampleRange range_;
  std::uint64_t pixels_, block_pixels_, block_samples_, columns_, layers_;
};

/// Counts finished work and tells the caller, from the caller's own thread and a few times a second.
class ProgressMeter {
 public:
  ProgressMeter(const Progress& progress, std::uint64_t total) : progress_(progress), total_(total) {}

  void add(std::uint64_t samples) {
    done_ += samples;
    if (std::this_thread::get_id() == owner_ && Clock::now() - reported_ >= kInterval) report();
  }
  void report() {
    reported_ = Clock::now();
    if (progress_ && !progress_(done_, total_)) stop_ = true;
  }
  bool stop_asked() const { return stop_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kInterval{200};

  const Progress& progress_;
  const std::uint64_t total_;
  const std::thread::id owner_ = std::this_thread::get_id();
  std::atomic<std::uint64_t> done_{0};
  Clock::time_point reported_ = Clock::now();
  bool stop_ = false;
};

struct CameraSample {
  Ray ray;
  double weight = 1.0;  ///< of the filter, negative in its negative lobes
};

class ReferenceRenderer final : public Renderer {
 public:
  ReferenceRenderer(const Scene& scene, const RenderSettings& settings, World::Rounding rounding)
      : rounding_(rounding), world_(std::in_place, scene, rounding), settings_(settings) {}

  std::string device_name() const override { return "reference"; }
  std::string driver_name() const override { return fmt::format("double precision, etendue {}", version()); }

  void set_view(const View& view, const RenderSettings& settings) override {
    world_->set_view(view);
    settings_ = settings;
  }

  void set_materials(const std::vector<Material>& materials) override;
  void set_scene(const SharedScene& scene, const RenderSettings& settings) override {
    world_.emplace(scene.scene(), rounding_);
    settings_ = settings;
  }
  std::uint32_t render(SampleRange range, Film& film, const Progress& progress,
                       std::vector<RejectedSample>& rejected) override;
  std::vector<SampleRecord> trace_samples(std::span<const SampleId> ids) override;
  std::vector<PathVertex> trace_path(SampleId id) override;

 private:
  void check_size(const Film& film) const;
  void render_pass(SampleRange pass, Film& film, ProgressMeter& meter, std::vector<RejectedSample>& rejected) const;
  CameraSample camera_sample(SampleId id, const SampleRandom& random) const;
  Vec3 radiance(const Ray& ray, const SampleRandom& random, DecisionLog& log) const;
  /// Adds one film sample: the mean over a set of paths, or one path where random numbers are independent.
  void add_set(SampleId set, int exponent, FilmPixel& pixel, std::vector<RejectedSample>& bad) const;
  /// What the film takes of one sample: radiance times filter weight, or its luminance.
  glm::vec3 sample_value(SampleId id, DecisionLog& log) const;

  World::Rounding rounding_;
  std::optional<World> world_;  ///< always there
  RenderSettings settings_;
};

void ReferenceRenderer::check_size(const Film& film) const {
  const Camera& camera = world_->scene().camera;
  if (film.width() == camera.width && film.height() == camera.height) return;
  throw Error(ErrorKind::usage,
              fmt::format("the film is {}x{} pixels but the camera of scene \"{}\" has {}x{}; "
                          "give both the same size",
                          film.width(), film.height(), world_->scene().name, camera.width, camera.height));
}

void ReferenceRenderer::set_materials(const std::vector<Material>& materials) {
  if (const std::string complaint = exchange_complaint(world_->scene().materials, materials); !complaint.empty())
    throw Error(ErrorKind::usage, fmt::format("the materials cannot be exchanged: {}", complaint));
  Diagnostics diagnostics;
  check_materials(materials, diagnostics);
  diagnostics.throw_first_error();
  world_->set_materials(materials);
}

CameraSample ReferenceRenderer::camera_sample(SampleId id, const SampleRandom& random) const {
  const Camera& camera = world_->scene().camera;
  const auto u = random.filter();
  const auto x = world_->filter().sample(u.x);
  const auto y = world_->filter().sample(u.y);
  const std::uint32_t column = id.pixel % camera.width, row = id.pixel / camera.width;
  const Vec2 film(column + 0.5 + x.offset, row + 0.5 + y.offset);
  return {camera_ray(camera, film, random.lens()), x.weight * y.weight * camera_weight(camera)};
}

Vec3 ReferenceRenderer::radiance(const Ray& ray, const SampleRandom& random, DecisionLog& log) const {
  switch (world_->scene().integrator.type) {
    case Integrator::Type::path:
    case Integrator::Type::whitted:
      return path_radiance(*world_, ray, random, log);
    case Integrator::Type::direct:
      return direct_radiance(*world_, ray, random, log);
    case Integrator::Type::aov:
      return aov_value(*world_, ray, random, log);
    case Integrator::Type::normals:
    case Integrator::Type::absolute_normals:
    case Integrator::Type::simple:
    case Integrator::Type::ambient_occlusion:
    case Integrator::Type::visibility:
    case Integrator::Type::depth:
    case Integrator::Type::distance:
      return first_hit_radiance(*world_, ray, random, log);
  }
  return Vec3(0.0);
}

glm::vec3 ReferenceRenderer::sample_value(SampleId id, DecisionLog& log) const {
  const SampleRandom random(settings_.seed, id.pixel, id.sample, world_->scene().sampler.set_bits);
  const CameraSample camera = camera_sample(id, random);
  const Integrator& integrator = world_->scene().integrator;
  const bool aov = integrator.type == Integrator::Type::aov;
  const double weight = aov ? aov_weight(world_->scene(), camera.weight, id.sample) : camera.weight;
  const Vec3 rgb = weight * radiance(camera.ray, random, log);
  return settings_.quantity == FilmQuantity::luminance ? glm::vec3(Vec3(luminance(rgb))) : glm::vec3(rgb);
}

void ReferenceRenderer::add_set(SampleId set, int exponent, FilmPixel& pixel, std::vector<RejectedSample>& bad) const {
  const std::uint32_t size = world_->scene().sampler.set_size();
  const std::size_t listed = bad.size();
  const std::uint32_t rejections = pixel.rejected;
  Vec3 sum(0.0);
  RejectedSample last;
  for (std::uint32_t i = 0; i < size; ++i) {
    const SampleId path{set.pixel, set.sample * size + i};
    DecisionLog log;
    const Vec3 value(sample_value(path, log));
    last = {path, log.segments()};
    if (!(glm::length(value) < INFINITY)) bad.push_back(last);
    sum += value;
  }
  pixel.add(glm::vec3(sum / static_cast<double>(size)), exponent);
  if (pixel.rejected != rejections && bad.size() == listed) bad.push_back(last);
}

void ReferenceRenderer::render_pass(SampleRange pass, Film& film, ProgressMeter& meter,
                                    std::vector<RejectedSample>& rejected) const {
  const BlockGrid grid(film, pass);
  std::mutex mutex;
  parallel_for(grid.size(), 1, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t index = begin; index < end; ++index) {
      const Block block = grid.block(index);
      std::vector<FilmPixel> partial(block.end_pixel - block.first_pixel);
      std::vector<RejectedSample> bad;
      for (std::uint64_t p = block.first_pixel; p < block.end_pixel; ++p) {
        FilmPixel& pixel = partial[p - block.first_pixel];
        for (std::uint32_t s = block.samples.begin; s < block.samples.end; ++s)
          add_set({static_cast<std::uint32_t>(p), s}, film.exponent(), pixel, bad);
      }
      {
        // Sums are integers: the order in which blocks arrive cannot matter.
        const std::lock_guard lock(mutex);
        for (std::size_t i = 0; i < partial.size(); ++i) film.pixels()[block.first_pixel + i].merge(partial[i]);
        rejected.insert(rejected.end(), bad.begin(), bad.end());
      }
      meter.add(partial.size() * block.samples.count());
    }
  });
}

std::uint32_t ReferenceRenderer::render(SampleRange range, Film& film, const Progress& progress,
                                        std::vector<RejectedSample>& rejected) {
  check_size(film);
  const std::uint64_t total = std::uint64_t{range.count()} * film.pixels().size();
  ProgressMeter meter(progress, total);
  std::vector<RejectedSample> found;
  // A pass is the least that can be kept when asked to stop: about a quarter of a second, at least one sample index.
  const std::uint64_t pass_samples =
      std::max<std::uint64_t>(1, std::uint64_t{65536} * thread_count() / film.pixels().size());
  std::uint32_t next = range.begin;
  while (next < range.end && !meter.stop_asked()) {
    const auto end = static_cast<std::uint32_t>(std::min<std::uint64_t>(next + pass_samples, range.end));
    render_pass({next, end}, film, meter, found);
    next = end;
    // The first ones by (sample, pixel): which 64 are listed must not depend on the threads.
    std::sort(found.begin(), found.end(), [](const RejectedSample& a, const RejectedSample& b) {
      return std::pair(a.id.sample, a.id.pixel) < std::pair(b.id.sample, b.id.pixel);
    });
    if (found.size() > kMaxListedRejections) found.resize(kMaxListedRejections);
  }
  meter.report();
  const std::size_t room = kMaxListedRejections - std::min(kMaxListedRejections, rejected.size());
  rejected.insert(rejected.end(), found.begin(),
                  found.begin() + static_cast<std::ptrdiff_t>(std::min(room, found.size())));
  return next;
}

std::vector<SampleRecord> ReferenceRenderer::trace_samples(std::span<const SampleId> ids) {
  std::vector<SampleRecord> records(ids.size());
  parallel_for(ids.size(), 256, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t i = begin; i < end; ++i) {
      DecisionLog log;
      records[i].radiance = sample_value(ids[i], log);
      records[i].signature = log.signature();
      records[i].segments = log.segments();
    }
  });
  return records;
}

std::vector<PathVertex> ReferenceRenderer::trace_path(SampleId id) {
  std::vector<PathVertex> vertices;
  DecisionLog log(&vertices);
  const SampleRandom random(settings_.seed, id.pixel, id.sample, world_->scene().sampler.set_bits);
  const CameraSample camera = camera_sample(id, random);
  radiance(camera.ray, random, log);
  for (PathVertex& vertex : vertices) vertex.radiance *= static_cast<float>(camera.weight);
  return vertices;
}

}  // namespace

std::unique_ptr<Renderer> make_reference_renderer(const Scene& scene, const RenderSettings& settings) {
  return std::make_unique<ReferenceRenderer>(scene, settings, World::Rounding::full);
}

std::unique_ptr<Renderer> make_shaken_reference_renderer(const Scene& scene, const RenderSettings& settings) {
  return std::make_unique<ReferenceRenderer>(scene, settings, World::Rounding::single);
}

}  // namespace etendue
