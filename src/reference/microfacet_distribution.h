#pragma once
/// Microfacets: how their normals are distributed, how much of them a direction sees, and how to sample those that it
/// sees. Directions are local and on the side z > 0.

#include "reference/vec.h"
#include "scene/bsdfs.h"

namespace etendue::reference {

class MicrofacetDistribution {
 public:
  explicit MicrofacetDistribution(const Roughness& roughness) : r_(roughness) {}

  /// Area of microfacets per solid angle of their normals `h` and area of the surface: ∫ D(h) h.z dh = 1 [Walter2007].
  double density(const Vec3& h) const;
  /// Share of the microfacets of normal `h` that `w` sees, as Mitsuba has it: that of Beckmann's distribution is a
  /// rational function within 0.4 % of the exact one [Walter2007, eq. 27]. 0 where `w` looks at their back.
  double masking(const Vec3& w, const Vec3& h) const;
  /// Density of sample_visible w.r.t. solid angle of `h`: D(h) w·h G1(w)/w.z with the exact G1 [Heitz2014, eq. 16].
  double visible_density(const Vec3& w, const Vec3& h) const;
  /// The normal of a microfacet that `w` sees, chosen by the area it sees of it; docs/conventions.md, "Microfacets".
  Vec3 sample_visible(const Vec3& w, const Vec2& u) const;

 private:
  Vec3 stretched(const Vec3& w) const {
    return glm::normalize(Vec3(r_.alpha_u.value * w.x, r_.alpha_v.value * w.y, w.z));
  }
  /// ∫ D(h) max(0, w·h) dh: what `w` sees of all microfacets, exactly; G1 = w.z / visible_area.
  double visible_area(const Vec3& w) const;

  Roughness r_;
};

}  // namespace etendue::reference
