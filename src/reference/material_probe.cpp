#include "reference/material_probe.h"
#include "core/parallel.h"
#include "core/version.h"
#include "reference/bsdf.h"
#include "reference/rng.h"

namespace etendue {
namespace {

constexpr std::uint64_t kSamplesAtATime = 4096;  // samples a thread takes at a time

class ReferenceBsdfProbe final : public BsdfProbe {
 public:
  explicit ReferenceBsdfProbe(const Bsdf& bsdf) : bsdf_(bsdf) {}

  std::string device_name() const override { return "reference"; }
  std::string driver_name() const override { return std::string("etendue ") + version(); }

  std::vector<BsdfDraw> sample(const glm::dvec3& wo, std::uint32_t seed, std::uint32_t first,
                               std::uint32_t count) override {
    std::vector<BsdfDraw> draws(count);
    parallel_for(count, kSamplesAtATime, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) {
        const auto random = reference::SampleRandom(seed, 0, first + static_cast<std::uint32_t>(i)).material(0);
        const reference::BsdfSample s = reference::sample(bsdf_, wo, random.lobe, {random.u, random.v});
        draws[i] = {s.wi, s.pdf, s.weight, static_cast<ProbeLobe>(s.lobe)};
      }
    });
    return draws;
  }

  std::vector<BsdfValue> evaluate(const glm::dvec3& wo, std::span<const glm::dvec3> wi) override {
    std::vector<BsdfValue> values;
    values.reserve(wi.size());
    for (const glm::dvec3& w : wi) values.push_back({reference::eval(bsdf_, wo, w), reference::pdf(bsdf_, wo, w)});
    return values;
  }

 private:
  Bsdf bsdf_;
};

}  // namespace

std::unique_ptr<BsdfProbe> make_reference_bsdf_probe(const Bsdf& bsdf) {
  return std::make_unique<ReferenceBsdfProbe>(bsdf);
}

}  // namespace etendue
