#include "image/tone_mapping.h"

#include <algorithm>
#include <cmath>

#include "image/vectors.h"

namespace etendue {
namespace {

// Krzysztof Narkowicz's fit of the ACES reference curve [Narkowicz2015], without the factor 0.6 that some programs
// apply before it.
double aces_curve(double x) {
  if (std::isinf(x)) return 1.0;
  return std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

// Filters and other programs can produce values below 0, for which neither curve is defined.
double at_least_zero(double x) {
  return x < 0.0 ? 0.0 : x;  // NaN stays
}

}  // namespace

const std::vector<std::string>& tone_map_names() {
  static const std::vector<std::string> names = {"none", "reinhard", "aces"};
  return names;
}

std::string name_of(ToneMap tone_map) {
  return tone_map_names()[static_cast<std::size_t>(tone_map)];
}

ToneMap tone_map_of(const std::string& name) {
  const auto& names = tone_map_names();
  return static_cast<ToneMap>(std::ranges::find(names, name) - names.begin());
}

glm::dvec3 tone_mapped(const glm::vec3& linear, const Display& display) {
  const glm::dvec3 exposed = glm::dvec3(linear) * std::exp2(display.exposure);
  if (display.tone_map == ToneMap::none) return exposed;
  glm::dvec3 c(at_least_zero(exposed.x), at_least_zero(exposed.y), at_least_zero(exposed.z));
  if (display.tone_map == ToneMap::aces) return {aces_curve(c.x), aces_curve(c.y), aces_curve(c.z)};
  // Multiplies all channels by the same factor, which preserves the hue.
  const double y = luminance(c);
  if (std::isinf(y)) return {c.x > 0.0 ? 1.0 : 0.0, c.y > 0.0 ? 1.0 : 0.0, c.z > 0.0 ? 1.0 : 0.0};
  return c / (1.0 + y);
}

}  // namespace etendue
