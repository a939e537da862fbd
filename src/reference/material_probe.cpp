#include "reference/material_probe.h"
#include "core/parallel.h"
#include "core/version.h"
#include "reference/scatterer.h"
#include "reference/test_patch.h"

namespace etendue {
namespace {

using reference::Vec3;

constexpr std::uint64_t kSamplesAtATime = 4096;  // samples a thread takes at a time

class ReferenceBsdfProbe final : public BsdfProbe {
 public:
  explicit ReferenceBsdfProbe(const Scene& patch) : patch_(patch), surface_(reference::patch_surface()) {}

  std::string device_name() const override { return "reference"; }
  std::string driver_name() const override { return std::string("etendue ") + version(); }

  std::vector<BsdfDraw> sample(const glm::dvec3& wo, std::uint32_t seed, std::uint32_t first,
                               std::uint32_t count) override {
    std::vector<BsdfDraw> draws(count);
    parallel_for(count, kSamplesAtATime, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) {
        const reference::SampleRandom random(seed, 0, first + static_cast<std::uint32_t>(i));
        const std::optional<reference::Mixture> met = scatterer(wo, random);
        if (!met) {
          draws[i] = {-wo, 1.0, Vec3(1.0), ProbeLobe::passed};
        } else if (!is_black(*met)) {
          const reference::BsdfSample s = met->draw(random.material(0));
          draws[i] = {s.wi, s.pdf, s.weight, static_cast<ProbeLobe>(s.lobe)};
        }
      }
    });
    return draws;
  }

  std::vector<BsdfValue> evaluate(const glm::dvec3& wo, std::uint32_t seed, std::span<const BsdfQuery> queries,
                                  Part part) override {
    std::vector<BsdfValue> values(queries.size());
    parallel_for(queries.size(), kSamplesAtATime, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) {
        const std::optional<reference::Mixture> met =
            scatterer(wo, reference::SampleRandom(seed, 0, queries[i].sample));
        if (!met || is_black(*met)) continue;
        const Vec3& wi = queries[i].wi;
        values[i] = part == Part::mixture ? BsdfValue{met->eval(wi), met->pdf(wi)}
                                          : BsdfValue{met->chosen().eval(wi), met->chosen().pdf(wi)};
      }
    });
    return values;
  }

 private:
  const Material& material() const { return patch_.materials[patch_.instances.front().material]; }
  /// Without adapters the functions of the material alone have to say what is black.
  bool is_black(const reference::Mixture& mixture) const { return material().adapter && mixture.black(); }

  /// What a sample meets; nothing if it passes.
  std::optional<reference::Mixture> scatterer(const Vec3& wo, const reference::SampleRandom& random) const {
    const auto made = [&](const reference::ChosenMaterial& m) {
      return reference::Scatterer(reference::material_at(patch_, m, surface_, -wo), m, wo);
    };
    if (!material().adapter) return reference::Mixture(made(reference::plain_material(patch_, surface_)));
    const auto found = reference::choose_materials(patch_, surface_, -wo, random, 0);
    if (!found) return std::nullopt;
    if (!found->other) return reference::Mixture(made(found->chosen));
    return reference::Mixture(made(found->chosen), found->share, made(*found->other));
  }

  Scene patch_;
  reference::Surface surface_;
};

}  // namespace

std::unique_ptr<BsdfProbe> make_reference_bsdf_probe(const Scene& patch) {
  return std::make_unique<ReferenceBsdfProbe>(patch);
}

}  // namespace etendue
