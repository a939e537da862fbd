// FLIP [Andersson2020] and HDR-FLIP [Andersson2021], written from the papers; section numbers are those of the first.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/parallel.h"
#include "image/vectors.h"
#include "validate/metrics.h"

namespace etendue {
namespace {

// Section 4.1.3: exponent of the colour difference, and the knee that gives the visible range 95 % of [0,1].
constexpr double kColorExponent = 0.7, kKneeIn = 0.4, kKneeOut = 0.95;
// Section 4.2: width of the feature detectors in degrees. The exponent of the feature difference is 0.5.
constexpr double kFeatureWidth = 0.082;

/// Contrast sensitivity of a channel as a sum of two Gaussians a √(π/b) exp(−π² x²/b), x in degrees (table 1).
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity kAchromatic{1.0, 0.0047, 0.0, 1e-5};
constexpr Sensitivity kRedGreen{1.0, 0.0053, 0.0, 1e-5};
constexpr Sensitivity kBlueYellow{34.1, 0.04, 13.5, 0.025};

// Rec. 709 primaries and D65 [IEC 61966-2-1], rows X Y Z; glm matrices are built by columns.
const glm::dmat3 kXyzFromRgb{{0.4123907992659595, 0.2126390058715104, 0.0193308187155918},
                             {0.3575843393838780, 0.7151686787677559, 0.1191947797946259},
                             {0.1804807884018343, 0.0721923153607337, 0.9505321522496608}};
const glm::dmat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const glm::dvec3 kWhite = kXyzFromRgb * glm::dvec3(1.0);

// The formulas in double for tests, and in float for pixels, where the powers take most of the time.

template <typename T>
glm::vec<3, T> rgb_of(const glm::vec<3, T>& ycxcz) {
  static const glm::mat<3, 3, T> rgb_from_xyz(kRgbFromXyz);
  static const glm::vec<3, T> white(kWhite);
  const T y = (ycxcz.x + T(16)) / T(116);
  return rgb_from_xyz * (white * glm::vec<3, T>(y + ycxcz.y / T(500), y, y - ycxcz.z / T(200)));
}

template <typename T>
glm::vec<3, T> hunt_lab_of(const glm::vec<3, T>& rgb) {
  static const glm::mat<3, 3, T> xyz_from_rgb(kXyzFromRgb);
  static const glm::vec<3, T> white(kWhite);
  constexpr T kDelta = T(6) / T(29);
  const auto f = [](T t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (T(3) * kDelta * kDelta) + T(4) / T(29);
  };
  const glm::vec<3, T> t = (xyz_from_rgb * rgb) / white;
  const T x = f(t.x), y = f(t.y), z = f(t.z), l = T(116) * y - T(16);
  return {l, T(0.01) * l * T(500) * (x - y), T(0.01) * l * T(200) * (y - z)};
}

template <typename T>
T hyab_of(const glm::vec<3, T>& a, const glm::vec<3, T>& b) {
  const T u = a.y - b.y, v = a.z - b.z;
  return std::abs(a.x - b.x) + std::sqrt(u * u + v * v);
}

template <typename T>
T redistributed(T hyab_distance) {
  // The largest difference the paper allows for: green against blue.
  static const T max = static_cast<T>(
      std::pow(hyab_of(hunt_lab_of(glm::dvec3(0, 1, 0)), hunt_lab_of(glm::dvec3(0, 0, 1))), kColorExponent));
  const T knee = T(kKneeIn) * max, error = std::pow(hyab_distance, T(kColorExponent));
  const T out =
      error < knee ? T(kKneeOut) / knee * error : T(kKneeOut) + (error - knee) / (max - knee) * (T(1) - T(kKneeOut));
  return std::min(out, T(1));
}

/// A picture of one channel.
struct Plane {
  int width = 0, height = 0;
  std::vector<float> values;
  Plane(int w, int h) : width(w), height(h), values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// Weights at −radius … radius.
using Kernel = std::vector<double>;

/// Along rows; the border pixel is repeated outside. Loops over x are innermost, so that they are vector code.
Plane convolve_rows(const Plane& in, const Kernel& kernel) {
  const std::size_t width = static_cast<std::size_t>(in.width), taps = kernel.size(), radius = taps / 2;
  Plane out(in.width, in.height);
  std::vector<float> padded(width + 2 * radius);
  for (int y = 0; y < in.height; ++y) {
    const float* row = &in.values[in.index(0, y)];
    std::fill_n(padded.begin(), radius, row[0]);
    std::copy_n(row, width, padded.begin() + static_cast<std::ptrdiff_t>(radius));
    std::fill_n(padded.end() - static_cast<std::ptrdiff_t>(radius), radius, row[width - 1]);
    float* to = &out.values[out.index(0, y)];
    for (std::size_t k = 0; k < taps; ++k) {
      const auto w = static_cast<float>(kernel[k]);
      const float* from = &padded[k];
      for (std::size_t x = 0; x < width; ++x) to[x] += w * from[x];
    }
  }
  return out;
}

/// Along columns.
Plane convolve_columns(const Plane& in, const Kernel& kernel) {
  const std::size_t width = static_cast<std::size_t>(in.width);
  const int radius = static_cast<int>(kernel.size() / 2);
  Plane out(in.width, in.height);
  for (int y = 0; y < in.height; ++y) {
    float* to = &out.values[out.index(0, y)];
    for (int k = -radius; k <= radius; ++k) {
      const auto w = static_cast<float>(kernel[static_cast<std::size_t>(k + radius)]);
      const float* from = &in.values[in.index(0, std::clamp(y + k, 0, in.height - 1))];
      for (std::size_t x = 0; x < width; ++x) to[x] += w * from[x];
    }
  }
  return out;
}

Plane convolve(const Plane& in, const Kernel& kx, const Kernel& ky) {
  return convolve_columns(convolve_rows(in, kx), ky);
}

/// Radius that holds three standard deviations of the widest sensitivity filter (b = 0.04), the same for all channels.
int sensitivity_radius(double ppd) {
  return static_cast<int>(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * kPi * kPi)) * ppd));
}

/// One Gaussian of a sensitivity filter; it separates, so its 2D sum is the square of its 1D sum.
Kernel gaussian(double b, double ppd, int radius) {
  Kernel kernel;
  for (int i = -radius; i <= radius; ++i) {
    const double x = i / ppd;
    kernel.push_back(std::exp(-kPi * kPi * x * x / b));
  }
  return kernel;
}

double sum_of(const Kernel& kernel) {
  double sum = 0;
  for (const double w : kernel) sum += w;
  return sum;
}

/// Section 4.1.1: filters a channel with its contrast sensitivity, normalised to sum 1.
Plane apply_sensitivity(const Plane& in, const Sensitivity& s, double ppd) {
  const int radius = sensitivity_radius(ppd);
  Kernel g1 = gaussian(s.b1, ppd, radius), g2 = gaussian(s.b2, ppd, radius);
  const double sum1 = sum_of(g1), sum2 = sum_of(g2);
  const double mass1 = s.a1 * std::sqrt(kPi / s.b1) * sum1 * sum1;
  const double mass2 = s.a2 * std::sqrt(kPi / s.b2) * sum2 * sum2;
  for (double& w : g1) w /= sum1;
  for (double& w : g2) w /= sum2;
  Plane out = convolve(in, g1, g1);
  if (mass2 == 0.0) return out;
  const Plane second = convolve(in, g2, g2);
  const double share = mass1 / (mass1 + mass2);
  for (std::size_t i = 0; i < out.values.size(); ++i) {
    out.values[i] = static_cast<float>(share * static_cast<double>(out.values[i]) +
                                       (1.0 - share) * static_cast<double>(second.values[i]));
  }
  return out;
}

struct Opponent {
  Plane y, cx, cz;
};

/// Clamps to the display's range and transforms; NaN is black.
Opponent opponent_planes(const std::vector<glm::vec3>& rgb, int width, int height) {
  Opponent planes{Plane(width, height), Plane(width, height), Plane(width, height)};
  for (std::size_t i = 0; i < rgb.size(); ++i) {
    glm::dvec3 c(rgb[i]);
    for (int k = 0; k < 3; ++k) c[k] = c[k] > 0.0 ? std::min(c[k], 1.0) : 0.0;
    const glm::dvec3 v = flip::ycxcz_from_rgb(c);
    planes.y.values[i] = static_cast<float>(v.x);
    planes.cx.values[i] = static_cast<float>(v.y);
    planes.cz.values[i] = static_cast<float>(v.z);
  }
  return planes;
}

/// Section 4.1: what the eye sees of the colours, in Hunt-adjusted L*a*b*.
std::vector<glm::vec3> perceived_colors(const Opponent& planes, double ppd) {
  const Plane y = apply_sensitivity(planes.y, kAchromatic, ppd);
  const Plane cx = apply_sensitivity(planes.cx, kRedGreen, ppd);
  const Plane cz = apply_sensitivity(planes.cz, kBlueYellow, ppd);
  std::vector<glm::vec3> out(y.values.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const glm::vec3 rgb = rgb_of(glm::vec3(y.values[i], cx.values[i], cz.values[i]));
    out[i] = hunt_lab_of(glm::clamp(rgb, 0.0f, 1.0f));
  }
  return out;
}

/// Positive weights scaled to sum 1, negative ones to −1.
void normalize_by_sign(Kernel& kernel) {
  double positive = 0, negative = 0;
  for (const double w : kernel) (w > 0 ? positive : negative) += w;
  for (double& w : kernel) w /= w > 0 ? positive : -negative;
}

/// Radius of the feature detectors: three standard deviations.
int feature_radius(double ppd) {
  return static_cast<int>(std::ceil(1.5 * kFeatureWidth * ppd));
}

/// Magnitudes of the detectors for edges (first derivative of a Gaussian) and points (second derivative).
struct Features {
  std::vector<float> edge, point;
};

/// Section 4.2: detectors on the achromatic channel, scaled to [0,1].
Features features(const Plane& y, double ppd) {
  const double sigma = 0.5 * kFeatureWidth * ppd;
  const int radius = feature_radius(ppd);
  Kernel smooth, first, second;
  for (int i = -radius; i <= radius; ++i) {
    const double g = std::exp(-i * i / (2.0 * sigma * sigma));
    smooth.push_back(g);
    first.push_back(-i * g);
    second.push_back((i * i / (sigma * sigma) - 1.0) * g);
  }
  const double sum = sum_of(smooth);
  for (double& w : smooth) w /= sum;
  normalize_by_sign(first);
  normalize_by_sign(second);

  Plane scaled = y;
  for (float& v : scaled.values) v = (v + 16.0f) / 116.0f;
  const Plane smoothed = convolve_rows(scaled, smooth);
  const auto magnitude = [&](const Kernel& derivative) {
    const Plane dx = convolve(scaled, derivative, smooth), dy = convolve_columns(smoothed, derivative);
    std::vector<float> out(dx.values.size());
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = std::sqrt(dx.values[i] * dx.values[i] + dy.values[i] * dy.values[i]);
    return out;
  };
  return {magnitude(first), magnitude(second)};
}

}  // namespace

namespace flip {

glm::dvec3 ycxcz_from_rgb(const glm::dvec3& rgb) {
  const glm::dvec3 t = (kXyzFromRgb * rgb) / kWhite;
  return {116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z)};
}

glm::dvec3 rgb_from_ycxcz(const glm::dvec3& v) {
  return rgb_of(v);
}

glm::dvec3 hunt_lab_from_rgb(const glm::dvec3& rgb) {
  return hunt_lab_of(rgb);
}

double hyab(const glm::dvec3& a, const glm::dvec3& b) {
  return hyab_of(a, b);
}

double redistribute(double hyab_distance) {
  return redistributed(hyab_distance);
}

double tone_map(double x) {
  x *= 0.6;
  return std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

}  // namespace flip

namespace {

using Pixels = std::vector<glm::vec3>;

/// LDR-FLIP of two pictures or strips of pictures, on this thread.
std::vector<float> ldr_flip_here(const Pixels& test, const Pixels& reference, int w, int h, double ppd) {
  const Opponent planes_t = opponent_planes(test, w, h), planes_r = opponent_planes(reference, w, h);
  const Features features_t = features(planes_t.y, ppd), features_r = features(planes_r.y, ppd);
  const Pixels colors_t = perceived_colors(planes_t, ppd), colors_r = perceived_colors(planes_r, ppd);
  std::vector<float> map(test.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const float color = redistributed(hyab_of(colors_t[i], colors_r[i]));
    const float difference = std::max(std::abs(features_t.edge[i] - features_r.edge[i]),
                                      std::abs(features_t.point[i] - features_r.point[i]));
    const float feature = std::sqrt(std::min(1.0f, difference / std::numbers::sqrt2_v<float>));
    map[i] = std::pow(color, 1.0f - feature);
  }
  return map;
}

/// Maps strips of rows in parallel, each with as many rows more on both sides as the filters reach: what a pixel gets
/// does not depend on the strips, and memory not on the size of the picture. `map` gives one value for each pixel it is
/// handed; `visit` gets the rows [y0, y1) and their first value, from any thread.
template <typename Map, typename Visit>
void for_strips(const Pixels& test, const Pixels& reference, std::uint32_t width, std::uint32_t height, double ppd,
                const Map& map, const Visit& visit) {
  constexpr std::uint32_t kRows = 64;
  const auto reach = static_cast<std::uint32_t>(std::max(sensitivity_radius(ppd), feature_radius(ppd)));
  parallel_for((height + kRows - 1) / kRows, 1, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t strip = begin; strip < end; ++strip) {
      const auto y0 = static_cast<std::uint32_t>(strip) * kRows, y1 = std::min(y0 + kRows, height);
      const std::uint32_t first = y0 - std::min(y0, reach), last = std::min(y1 + reach, height);
      const auto rows = [&](const Pixels& picture) {
        const auto from = picture.begin() + static_cast<std::ptrdiff_t>(first) * width;
        return Pixels(from, from + static_cast<std::ptrdiff_t>(last - first) * width);
      };
      const std::vector<float> values =
          map(rows(test), rows(reference), static_cast<int>(width), static_cast<int>(last - first));
      visit(y0, y1, &values[std::size_t{y0 - first} * width]);
    }
  });
}

/// The whole map of a strip-wise computation.
template <typename Map>
std::vector<float> whole_map(const Pixels& test, const Pixels& reference, std::uint32_t width, std::uint32_t height,
                             double ppd, const Map& map) {
  std::vector<float> out(test.size());
  for_strips(test, reference, width, height, ppd, map, [&](std::uint32_t y0, std::uint32_t y1, const float* values) {
    std::copy_n(values, std::size_t{y1 - y0} * width, &out[std::size_t{y0} * width]);
  });
  return out;
}

/// The mean of it, the same for any number of threads.
template <typename Map>
double map_mean(const Pixels& test, const Pixels& reference, std::uint32_t width, std::uint32_t height, double ppd,
                const Map& map) {
  std::vector<double> rows(height, 0.0);
  for_strips(test, reference, width, height, ppd, map, [&](std::uint32_t y0, std::uint32_t y1, const float* values) {
    for (std::uint32_t y = y0; y < y1; ++y) {
      for (std::uint32_t x = 0; x < width; ++x) rows[y] += static_cast<double>(*values++);
    }
  });
  double sum = 0;
  for (const double row : rows) sum += row;
  return sum / static_cast<double>(test.size());
}

/// The map function of LDR-FLIP for for_strips.
auto ldr_map(double ppd) {
  return [ppd](const Pixels& test, const Pixels& reference, int w, int h) {
    return ldr_flip_here(test, reference, w, h, ppd);
  };
}

}  // namespace

std::vector<float> ldr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference,
                            std::uint32_t width, std::uint32_t height, double pixels_per_degree) {
  return whole_map(test, reference, width, height, pixels_per_degree, ldr_map(pixels_per_degree));
}

double mean_ldr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference, std::uint32_t width,
                     std::uint32_t height, double pixels_per_degree) {
  return map_mean(test, reference, width, height, pixels_per_degree, ldr_map(pixels_per_degree));
}

std::vector<double> hdr_flip_exposures(const std::vector<glm::vec3>& reference) {
  std::vector<double> y;
  y.reserve(reference.size());
  for (const glm::vec3& c : reference) {
    const double v =
        0.2126 * static_cast<double>(c.x) + 0.7152 * static_cast<double>(c.y) + 0.0722 * static_cast<double>(c.z);
    y.push_back(std::isfinite(v) ? std::max(v, 0.0) : 0.0);
  }
  const double brightest = *std::max_element(y.begin(), y.end());
  const auto middle = y.begin() + static_cast<std::ptrdiff_t>(y.size() / 2);
  std::nth_element(y.begin(), middle, y.end());
  double median = *middle;
  if (y.size() % 2 == 0) median = 0.5 * (median + *std::max_element(y.begin(), middle));
  if (brightest <= 0.0) return {0.0, 0.0};  // a black reference: any exposure shows the same

  // The x whose tone-mapped value is 0.85: positive root of a quadratic.
  constexpr double kTarget = 0.85, kScale = 0.6;
  const double a = kScale * kScale * (kTarget * 2.43 - 2.51), b = kScale * (kTarget * 0.59 - 0.03), c = kTarget * 0.14;
  const double half = -b / (2.0 * a), root = std::sqrt(half * half - c / a);
  const double x = half + root;
  constexpr double kDarkest = 1e-6;  // a median of 0 would ask for infinite exposure
  const double start = std::log2(x / brightest), stop = std::log2(x / std::max(median, kDarkest * brightest));
  const int count = std::max(2, static_cast<int>(std::ceil(stop - start)));
  std::vector<double> exposures;
  exposures.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) exposures.push_back(start + (stop - start) * i / (count - 1));
  return exposures;
}

namespace {

Pixels exposed(const Pixels& picture, double exposure) {
  const double factor = std::exp2(exposure);
  Pixels out(picture.size());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double v = static_cast<double>(picture[i][k]) * factor;
      // Infinity is white, NaN and negative values are black.
      out[i][k] = v > 0.0 ? static_cast<float>(std::isinf(v) ? 1.0 : flip::tone_map(v)) : 0.0f;
    }
  }
  return out;
}

/// The map function of HDR-FLIP: the worst of all exposures.
auto hdr_map(std::vector<double> exposures, double ppd) {
  return [exposures = std::move(exposures), ppd](const Pixels& test, const Pixels& reference, int w, int h) {
    std::vector<float> worst(test.size(), 0.0f);
    for (const double exposure : exposures) {
      const std::vector<float> map = ldr_flip_here(exposed(test, exposure), exposed(reference, exposure), w, h, ppd);
      for (std::size_t i = 0; i < worst.size(); ++i) worst[i] = std::max(worst[i], map[i]);
    }
    return worst;
  };
}

}  // namespace

std::vector<float> hdr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference,
                            std::uint32_t width, std::uint32_t height, double pixels_per_degree) {
  return whole_map(test, reference, width, height, pixels_per_degree,
                   hdr_map(hdr_flip_exposures(reference), pixels_per_degree));
}

double mean_hdr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference, std::uint32_t width,
                     std::uint32_t height, double pixels_per_degree) {
  return map_mean(test, reference, width, height, pixels_per_degree,
                  hdr_map(hdr_flip_exposures(reference), pixels_per_degree));
}

}  // namespace etendue
