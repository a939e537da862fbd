// FLIP [Andersson2020] and HDR-FLIP [Andersson2021], written from the papers; section numbers are those of the first.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/parallel.h"
#include "validate/metrics.h"

namespace etendue {
namespace {

constexpr double kPi = std::numbers::pi;
// Section 4.1.3: exponent of the colour difference, and the knee that gives the visible range 95 % of [0,1].
constexpr double kColorExponent = 0.7, kKneeIn = 0.4, kKneeOut = 0.95;
// Section 4.2: width of the feature detectors in degrees, exponent of the feature difference.
constexpr double kFeatureWidth = 0.082, kFeatureExponent = 0.5;

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

/// Convolves with kx along rows and ky along columns; the border pixel is repeated outside.
Plane convolve(const Plane& in, const Kernel& kx, const Kernel& ky) {
  const int rx = static_cast<int>(kx.size() / 2), ry = static_cast<int>(ky.size() / 2);
  const double *const weight_x = kx.data() + rx, *const weight_y = ky.data() + ry;
  Plane middle(in.width, in.height), out(in.width, in.height);
  constexpr std::uint64_t kRows = 16;
  parallel_for(static_cast<std::uint64_t>(in.height), kRows, [&](std::uint64_t begin, std::uint64_t end) {
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < in.width; ++x) {
        double sum = 0;
        for (int k = -rx; k <= rx; ++k) {
          sum += weight_x[k] * static_cast<double>(in.values[in.index(std::clamp(x + k, 0, in.width - 1), y)]);
        }
        middle.values[in.index(x, y)] = static_cast<float>(sum);
      }
    }
  });
  parallel_for(static_cast<std::uint64_t>(in.height), kRows, [&](std::uint64_t begin, std::uint64_t end) {
    std::vector<double> row(static_cast<std::size_t>(in.width));
    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      std::fill(row.begin(), row.end(), 0.0);
      for (int k = -ry; k <= ry; ++k) {
        const float* from = &middle.values[in.index(0, std::clamp(y + k, 0, in.height - 1))];
        const double w = weight_y[k];
        for (std::size_t x = 0; x < row.size(); ++x) row[x] += w * static_cast<double>(from[x]);
      }
      for (int x = 0; x < in.width; ++x)
        out.values[in.index(x, y)] = static_cast<float>(row[static_cast<std::size_t>(x)]);
    }
  });
  return out;
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
  parallel_for(out.size(), 4096, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const glm::dvec3 rgb = flip::rgb_from_ycxcz({y.values[i], cx.values[i], cz.values[i]});
      out[i] = glm::vec3(flip::hunt_lab_from_rgb(glm::clamp(rgb, 0.0, 1.0)));
    }
  });
  return out;
}

/// Positive weights scaled to sum 1, negative ones to −1.
void normalize_by_sign(Kernel& kernel) {
  double positive = 0, negative = 0;
  for (const double w : kernel) (w > 0 ? positive : negative) += w;
  for (double& w : kernel) w /= w > 0 ? positive : -negative;
}

/// Magnitudes of the detectors for edges (first derivative of a Gaussian) and points (second derivative).
struct Features {
  std::vector<float> edge, point;
};

/// Section 4.2: detectors on the achromatic channel, scaled to [0,1].
Features features(const Plane& y, double ppd) {
  const double sigma = 0.5 * kFeatureWidth * ppd;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
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
  const auto magnitude = [&](const Kernel& derivative) {
    const Plane dx = convolve(scaled, derivative, smooth), dy = convolve(scaled, smooth, derivative);
    std::vector<float> out(dx.values.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(dx.values[i], dy.values[i]);
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
  const double y = (v.x + 16.0) / 116.0;
  return kRgbFromXyz * (kWhite * glm::dvec3(y + v.y / 500.0, y, y - v.z / 200.0));
}

glm::dvec3 hunt_lab_from_rgb(const glm::dvec3& rgb) {
  constexpr double kDelta = 6.0 / 29.0;
  const auto f = [](double t) {
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
  };
  const glm::dvec3 t = (kXyzFromRgb * rgb) / kWhite;
  const double l = 116.0 * f(t.y) - 16.0;
  return {l, 0.01 * l * 500.0 * (f(t.x) - f(t.y)), 0.01 * l * 200.0 * (f(t.y) - f(t.z))};
}

double hyab(const glm::dvec3& a, const glm::dvec3& b) {
  return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

double redistribute(double hyab_distance) {
  // The largest difference the paper allows for: green against blue.
  static const double kMax = std::pow(hyab(hunt_lab_from_rgb({0, 1, 0}), hunt_lab_from_rgb({0, 0, 1})), kColorExponent);
  const double knee = kKneeIn * kMax;
  const double error = std::pow(hyab_distance, kColorExponent);
  const double out =
      error < knee ? kKneeOut / knee * error : kKneeOut + (error - knee) / (kMax - knee) * (1.0 - kKneeOut);
  return std::min(out, 1.0);
}

double tone_map(double x) {
  x *= 0.6;
  return std::clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

}  // namespace flip

std::vector<float> ldr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference,
                            std::uint32_t width, std::uint32_t height, double pixels_per_degree) {
  const int w = static_cast<int>(width), h = static_cast<int>(height);
  const Opponent planes_t = opponent_planes(test, w, h), planes_r = opponent_planes(reference, w, h);
  const Features features_t = features(planes_t.y, pixels_per_degree);
  const Features features_r = features(planes_r.y, pixels_per_degree);
  const std::vector<glm::vec3> colors_t = perceived_colors(planes_t, pixels_per_degree);
  const std::vector<glm::vec3> colors_r = perceived_colors(planes_r, pixels_per_degree);
  std::vector<float> map(test.size());
  parallel_for(map.size(), 4096, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double color = flip::redistribute(flip::hyab(colors_t[i], colors_r[i]));
      const double difference = std::max(std::abs(features_t.edge[i] - features_r.edge[i]),
                                         std::abs(features_t.point[i] - features_r.point[i]));
      const double feature = std::pow(std::min(1.0, difference / std::numbers::sqrt2), kFeatureExponent);
      map[i] = static_cast<float>(std::pow(color, 1.0 - feature));
    }
  });
  return map;
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

std::vector<float> hdr_flip(const std::vector<glm::vec3>& test, const std::vector<glm::vec3>& reference,
                            std::uint32_t width, std::uint32_t height, double pixels_per_degree) {
  const auto exposed = [](const std::vector<glm::vec3>& picture, double exposure) {
    const double factor = std::exp2(exposure);
    std::vector<glm::vec3> out(picture.size());
    for (std::size_t i = 0; i < picture.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const double v = static_cast<double>(picture[i][k]) * factor;
        // Infinity is white, NaN and negative values are black.
        out[i][k] = v > 0.0 ? static_cast<float>(std::isinf(v) ? 1.0 : flip::tone_map(v)) : 0.0f;
      }
    }
    return out;
  };
  std::vector<float> worst(test.size(), 0.0f);
  for (const double exposure : hdr_flip_exposures(reference)) {
    const std::vector<float> map =
        ldr_flip(exposed(test, exposure), exposed(reference, exposure), width, height, pixels_per_degree);
    for (std::size_t i = 0; i < worst.size(); ++i) worst[i] = std::max(worst[i], map[i]);
  }
  return worst;
}

}  // namespace etendue
