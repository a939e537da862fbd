#include "formats/mitsuba/spectrum.h"

#include <algorithm>
#include <cmath>

#include "formats/mitsuba/cie_tables.h"

namespace etendue {
namespace {

/// Converts CIE XYZ to Rec. 709 with the white point D65; six decimals (ITU-R BT.709).
glm::dvec3 rec709_of_xyz(const glm::dvec3& c) {
  return {3.240479 * c.x - 1.537150 * c.y - 0.498535 * c.z, -0.969256 * c.x + 1.875991 * c.y + 0.041556 * c.z,
          0.055648 * c.x - 0.204043 * c.y + 1.057311 * c.z};
}

/// ∫ ȳ dλ. Dividing by it makes the luminance of a flat spectrum 1.
constexpr double kLuminance = 106.856895;
/// The table's D65 is 100 at 560 nm; this factor makes its luminance 1, to the five digits that Mitsuba has.
constexpr double kD65Scale = 0.01010127305984497;

/// The position of a wavelength in the tables.
struct Place {
  int first;
  double share;  ///< weight of the entry after `first`
};
Place place_of(double wavelength) {
  const double x = std::clamp((wavelength - cie::kFirstWavelength) / cie::kStep, 0.0, cie::kCount - 1.0);
  const int first = std::min(static_cast<int>(x), cie::kCount - 2);
  return {first, x - first};
}

glm::dvec3 observer(double wavelength) {
  const Place p = place_of(wavelength);
  glm::dvec3 xyz;
  for (int i = 0; i < 3; ++i) xyz[i] = std::lerp(cie::kObserver[p.first][i], cie::kObserver[p.first + 1][i], p.share);
  return xyz;
}

double d65(double wavelength) {
  const Place p = place_of(wavelength);
  return kD65Scale * std::lerp(cie::kD65[p.first], cie::kD65[p.first + 1], p.share);
}

}  // namespace

glm::dvec3 to_rec709(const std::vector<SpectrumPoint>& points, SpectrumUse use) {
  constexpr int kSteps = 1000;  // less than half a nanometre each: five digits for any smooth spectrum
  constexpr double kRange = cie::kStep * (cie::kCount - 1);
  glm::dvec3 sum(0.0);
  std::size_t next = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double wavelength = cie::kFirstWavelength + kRange * i / (kSteps - 1);
    while (next < points.size() && points[next].wavelength <= wavelength) ++next;
    double value = 0.0;
    if (next > 0 && next < points.size()) {
      const SpectrumPoint &a = points[next - 1], &b = points[next];
      value = std::lerp(a.value, b.value, (wavelength - a.wavelength) / (b.wavelength - a.wavelength));
    } else if (next > 0 && points.back().wavelength == wavelength) {
      value = points.back().value;
    }
    if (use != SpectrumUse::emission) value *= d65(wavelength);
    const double weight = i == 0 || i == kSteps - 1 ? 0.5 : 1.0;
    sum += weight * value * observer(wavelength);
  }
  const glm::dvec3 color = rec709_of_xyz(sum * (kRange / (kSteps - 1) / kLuminance));
  if (use == SpectrumUse::reflectance) return glm::clamp(color, 0.0, 1.0);
  return glm::max(color, 0.0);
}

glm::dvec3 to_rec709(double value, SpectrumUse use) {
  return use == SpectrumUse::emission ? rec709_of_xyz(glm::dvec3(value)) : glm::dvec3(value);
}

double linear_of_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

}  // namespace etendue
