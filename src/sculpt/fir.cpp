#include "sculpt/field.h"

#include <algorithm>

namespace etendue::sculpt {
namespace {

constexpr int kSkirts = 9;

// Tiers of branches, one above the other: cones with lobes that are hollow below, with bumps of the size of twigs.
double value(Vec3 p) {
  const double r = std::sqrt(p.x * p.x + p.z * p.z) + 1e-9;
  const double c = p.x / r, s = p.z / r;
  const double c3 = c * (4.0 * c * c - 3.0), s3 = s * (3.0 - 4.0 * s * s);  // cosine and sine of three times the angle
  double crown = 1e9;
  for (int i = 0; i < kSkirts; ++i) {
    const double t = static_cast<double>(i) / kSkirts;
    const double bottom = 0.16 + 0.72 * t, top = bottom + 0.15 + 0.06 * (1.0 - t), reach = 0.03 + 0.22 * (1.0 - t);
    // The lobes of one tier are between those of the next.
    const double lobes = (i % 2 == 0 ? 2.0 * s3 * c3 : c3 * c3 - s3 * s3) * std::min(1.0, 8.0 * r);
    const double wide = reach * (1.0 + 0.16 * lobes), height = top - bottom;
    const double cone = (r * height + (p.y - top) * wide) / std::sqrt(height * height + wide * wide);
    const double under = 0.85 * (bottom + 0.35 * (wide - r) - p.y);
    crown = join(crown, intersect(cone, under, 0.02), 0.01);
  }
  return crown - 0.020 * noise(21.0 * p) - 0.007 * noise(57.0 * p);
}

}  // namespace

Solid fir() {
  return {value, {-0.4, 0.05, -0.4}, {0.4, 1.15, 0.4}, 3.5};
}

}  // namespace etendue::sculpt
