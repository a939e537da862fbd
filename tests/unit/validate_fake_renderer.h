#pragma once
// A renderer without a scene: each sample is a random walk of three vertices whose expectation is known, computed from
// a hash of (seed, pixel, sample), so that everything a Renderer promises holds. Its defects are what validate has to
// find.

#include <cmath>
#include <limits>
#include <memory>

#include "render/renderer.h"
#include "validate/renderer_factory.h"

namespace etendue::test {

struct Defects {
  float bias = 1.0f;  // factor on what the vertex `biased_bounce` adds
  std::uint32_t biased_bounce = 1;
  float rounding = 0.0f;         // relative noise of each contribution
  std::uint32_t flip_every = 0;  // one sample in so many takes another lobe, with another value of the same expectation
  std::uint32_t nan_every = 0;
  bool reuse_seed = false;  // another random sequence than the seed asks for
  bool heavy = false;       // Pareto contributions with infinite variance
  bool constant = false;    // no variance at all
};

class FakeRenderer : public Renderer {
 public:
  FakeRenderer(const Scene& scene, const RenderSettings& settings, Defects defects)
      : pixels_(scene.camera.width * scene.camera.height),
        exponent_(film_exponent(scene)),
        settings_(settings),
        defects_(defects) {}

  std::string device_name() const override { return "fake"; }
  std::string driver_name() const override { return "1.0"; }

  void set_view(const View& view, const RenderSettings& settings) override {
    pixels_ = view.camera.width * view.camera.height;
    settings_ = settings;
  }

  void set_materials(const std::vector<Material>&) override {}
  void set_scene(const SharedScene&, const RenderSettings&) override {}

  std::uint32_t render(SampleRange range, Film& film, const Progress& progress,
                       std::vector<RejectedSample>& rejected) override {
    for (std::uint32_t p = 0; p < pixels_; ++p) {
      for (std::uint32_t s = range.begin; s < range.end; ++s) {
        glm::vec3 v = trace({p, s}, nullptr).radiance;
        if (settings_.quantity == FilmQuantity::luminance) {
          v = glm::vec3(0.212671f * v.x + 0.715160f * v.y + 0.072169f * v.z);
        }
        const std::uint32_t before = film.pixels()[p].rejected;
        film.pixels()[p].add(v, exponent_);
        if (film.pixels()[p].rejected != before && rejected.size() < 64) rejected.push_back({{p, s}, 2});
      }
    }
    return progress && !progress(1, 1) ? range.begin : range.end;
  }

  std::vector<SampleRecord> trace_samples(std::span<const SampleId> ids) override {
    std::vector<SampleRecord> out;
    for (const SampleId& id : ids) out.push_back(trace(id, nullptr));
    return out;
  }

  std::vector<PathVertex> trace_path(SampleId id) override {
    std::vector<PathVertex> path;
    trace(id, &path);
    return path;
  }

  // Expectation of every channel in every pixel.
  static constexpr double kMean = 1.5;

 private:
  static std::uint32_t hash(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    std::uint64_t h = 0x9e3779b97f4a7c15ull;
    for (const std::uint32_t word : {a, b, c, d}) {
      h ^= word;
      h *= 0xbf58476d1ce4e5b9ull;
      h ^= h >> 29;
      h *= 0x94d049bb133111ebull;
      h ^= h >> 32;
    }
    return static_cast<std::uint32_t>(h);
  }

  SampleRecord trace(SampleId id, std::vector<PathVertex>* path) const {
    const std::uint32_t seed = defects_.reuse_seed ? settings_.seed + 77 : settings_.seed;
    const auto u = [&](std::uint32_t block) {
      return static_cast<float>(hash(seed, id.pixel, id.sample, block) >> 8) * 0x1p-24f;
    };
    const auto every = [&](std::uint32_t n, std::uint32_t salt) {
      return n != 0 && hash(1, id.pixel, id.sample, salt) % n == 0;
    };
    SampleRecord record;
    record.signature = 0x811c9dc5u;
    float scale = 1.0f;
    for (std::uint32_t bounce = 0; bounce < 3; ++bounce) {
      PathVertex v;
      v.instance = static_cast<std::uint32_t>(u(10 + bounce) * 5.0f);
      v.primitive = 0;
      v.lobe = every(defects_.flip_every, 5) && bounce == 2 ? 2 : 1;
      float x = v.lobe == 2 ? 2.0f * u(50 + bounce) : 2.0f * u(20 + bounce);  // mean 1
      if (defects_.heavy && bounce == 0) x = 0.01f * std::pow(1.0f - u(30), -1.0f);
      if (defects_.constant) x = 1.0f;
      if (bounce == defects_.biased_bounce) x *= defects_.bias;
      x *= 1.0f + defects_.rounding * (2.0f * u(40 + bounce) - 1.0f);
      if (every(defects_.nan_every, 6) && bounce == 1) x = std::numeric_limits<float>::quiet_NaN();
      scale *= 0.5f;
      record.radiance += glm::vec3(x * scale * (1.5f / 0.875f));
      for (const std::uint32_t word : {v.instance + 1, v.primitive + 1, v.lobe})
        record.signature = (record.signature ^ word) * 0x01000193u;
      v.radiance = record.radiance;
      if (path) path->push_back(v);
    }
    record.segments = 3;
    return record;
  }

  std::uint32_t pixels_;
  int exponent_;
  RenderSettings settings_;
  Defects defects_;
};

inline RendererFactory fake(Defects defects = {}) {
  return [defects](const SharedScene& scene, const RenderSettings& settings) {
    return std::make_unique<FakeRenderer>(scene.scene(), settings, defects);
  };
}

inline Scene small_scene(std::uint32_t width, std::uint32_t height, std::uint32_t spp = 16) {
  Scene scene;
  scene.name = "small";
  scene.file = "small.xml";
  scene.camera.width = width;
  scene.camera.height = height;
  scene.sampler.sample_count = spp;
  return scene;
}

}  // namespace etendue::test
