#pragma once
/// A material where a path has met it.

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "reference/adapters.h"
#include "reference/bsdf.h"
#include "reference/frame.h"

namespace etendue::reference {

/// A material at a point of the surface, in world space. The shading normal alone decides which side a direction is on.
class Scatterer {
 public:
  Scatterer(Bsdf bsdf, const ChosenMaterial& chosen, const Vec3& wo)
      : bsdf_(std::move(bsdf)),
        frame_(chosen.frame),
        base_(chosen.base),
        shadowed_(chosen.shadowed),
        wo_(frame_.to_local(wo)),
        unseen_(base_ && !agrees(wo)) {}

  /// The normal by which lights are chosen; 0 where light from both sides counts.
  Vec3 light_normal() const { return traits(bsdf_).transmissive ? Vec3(0.0) : frame_.normal(); }
  /// Absorption, per scene unit, of what light enters in the direction `wi` that has come through `current`.
  Vec3 absorption_toward(const Vec3& wi, const Vec3& current) const {
    const auto* solid = std::get_if<GltfBsdf>(&bsdf_);
    if (solid == nullptr || solid->thin || !traits(bsdf_).transmissive) return current;
    if (glm::dot(wi, frame_.normal()) >= 0.0) return Vec3(0.0);
    return -glm::log(solid->attenuation_color) / solid->attenuation_distance;
  }
  /// Nothing but delta lobes scatter.
  bool delta() const { return reference::is_delta(bsdf_); }
  /// Nothing scatters toward `wo`.
  bool black() const { return unseen_ || (is_one_sided(bsdf_) && wo_.z <= 0.0); }

  /// The fraction of light from `w` that a turned normal leaves.
  double carried(const Vec3& w) const { return agrees(w) ? share(w) : 0.0; }

  Vec3 eval(const Vec3& wi) const {
    return agrees(wi) ? share(wi) * reference::eval(bsdf_, wo_, frame_.to_local(wi)) : Vec3(0.0);
  }
  double pdf(const Vec3& wi) const { return reference::pdf(bsdf_, wo_, frame_.to_local(wi)); }
  /// Like that of bsdf.h, with `wi` in world space.
  BsdfSample sample(const SampleRandom::Material& random) const {
    BsdfSample sample = reference::sample(bsdf_, wo_, random.lobe, {random.u, random.v});
    if (sample.lobe == Lobe::none) return {};
    sample.wi = frame_.to_world(sample.wi);
    sample.weight *= carried(sample.wi);
    return sample;
  }
  /// Light is absorbed behind it.
  bool encloses() const { return !is_zero(absorption_toward(-frame_.normal(), Vec3(0.0))); }

 private:
  /// A direction on one side of the normal and, where a map has turned it, of the normal before: others carry no light.
  bool agrees(const Vec3& w) const { return !base_ || glm::dot(*base_, w) * glm::dot(frame_.normal(), w) > 0.0; }

  /// What microfacets as steep as the turned normal leave of light from `w` [Conty2019].
  double share(const Vec3& w) const {
    if (!base_ || !shadowed_) return 1.0;
    const auto tan2 = [](double cosine) { return std::max(0.0, 1.0 / (cosine * cosine) - 1.0); };
    const double slope2 = tan2(glm::dot(*base_, frame_.normal()));
    return 2.0 / (1.0 + std::sqrt(1.0 + std::min(0.125 * slope2, 1.0) * tan2(glm::dot(*base_, w))));
  }

  Bsdf bsdf_;  // its parameters have the values that they have here
  Frame frame_;
  std::optional<Vec3> base_;
  bool shadowed_;
  Vec3 wo_;
  bool unseen_;
};

/// What a vertex of a path scatters by: a material, or a mixture of two, of which one was chosen with the probability
/// that is its share. A mixture reflects `share f₁ + (1 − share) f₂`, whichever was chosen.
class Mixture {
 public:
  explicit Mixture(Scatterer chosen) : chosen_(std::move(chosen)) {}
  Mixture(Scatterer chosen, double share, Scatterer other) : Mixture(std::move(chosen)) {
    if (chosen_.black() || other.black() || chosen_.encloses() || other.encloses()) return;
    other_ = std::move(other);
    share_ = share;
  }

  const Scatterer& chosen() const { return chosen_; }
  bool mixed() const { return other_.has_value(); }
  /// As those of a single material. Lights have to be chosen alike whichever material was.
  Vec3 light_normal() const {
    return !other_ || other_->light_normal() == chosen_.light_normal() ? chosen_.light_normal() : Vec3(0.0);
  }
  Vec3 absorption_toward(const Vec3& wi, const Vec3& current) const { return chosen_.absorption_toward(wi, current); }
  bool delta() const { return chosen_.delta() && (!other_ || other_->delta()); }
  bool black() const { return chosen_.black(); }
  Vec3 eval(const Vec3& wi) const {
    return other_ ? share_ * chosen_.eval(wi) + (1.0 - share_) * other_->eval(wi) : chosen_.eval(wi);
  }
  double pdf(const Vec3& wi) const {
    return other_ ? share_ * chosen_.pdf(wi) + (1.0 - share_) * other_->pdf(wi) : chosen_.pdf(wi);
  }
  /// A direction by the chosen one; lobe `none` unless its weight is positive somewhere.
  BsdfSample sample(const SampleRandom::Material& random) const {
    const BsdfSample sample = draw(random);
    return is_zero(sample.weight) ? BsdfSample{} : sample;
  }
  /// The same, whether it carries light or not.
  BsdfSample draw(const SampleRandom::Material& random) const {
    BsdfSample sample = chosen_.sample(random);
    if (sample.lobe == Lobe::none) return {};
    if (other_ && !is_delta(sample.lobe)) {
      const double density = share_ * sample.pdf + (1.0 - share_) * other_->pdf(sample.wi);
      sample.weight = (share_ * sample.pdf * sample.weight + (1.0 - share_) * other_->eval(sample.wi)) / density;
      sample.pdf = density;
    }
    return sample;
  }

 private:
  Scatterer chosen_;
  double share_ = 1.0;
  std::optional<Scatterer> other_;
};

}  // namespace etendue::reference
