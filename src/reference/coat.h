#pragma once
/// A clear coat over a diffuse base: light enters, is scattered by the base, is partly reflected back inside, and
/// leaves. docs/conventions.md, "Coats".

#include <cstddef>

#include "reference/vec.h"
#include "scene/bsdfs.h"

namespace etendue::reference {

/// Fraction of diffuse light that a smooth boundary reflects back inside; fit by [dEon2011].
double diffuse_reflectance_inside(double int_ior, double ext_ior);

/// A coat of isotropic microfacets, tabulated at 64 cosines evenly spaced over [0, 1].
class RoughCoat {
 public:
  static constexpr std::size_t kNodes = 64;
  RoughCoat(const Roughness& roughness, double int_ior, double ext_ior);

  /// Fraction of light from a direction of this cosine that enters; linear between the nodes.
  double transmittance(double cosine) const;
  double reflectance_inside() const { return inside_; }

 private:
  double nodes_[kNodes];
  double inside_ = 0.0;
};

/// A rough coat at a point. If its roughness is textured, it is interpolated between the two nearest of 16 coats whose
/// roots of the roughness are evenly spaced over [0, 1] (the first has the smallest roughness allowed).
class CoatAt {
 public:
  CoatAt(Roughness::Distribution distribution, const ScalarParameter& alpha, double int_ior, double ext_ior);

  double transmittance(double cosine) const {
    return between(lower_->transmittance(cosine), upper_->transmittance(cosine));
  }
  double reflectance_inside() const { return between(lower_->reflectance_inside(), upper_->reflectance_inside()); }

 private:
  double between(double a, double b) const { return (1.0 - way_) * a + way_ * b; }

  const RoughCoat* lower_;
  const RoughCoat* upper_;
  double way_ = 0.0;
};

/// f cos of the base, from its albedo, the fraction reflected back inside, and the fractions that enter and leave.
Vec3 coated_base(const Vec3& albedo, bool nonlinear, double inside, double ratio, double enters, double leaves,
                 double cos_i);

}  // namespace etendue::reference
