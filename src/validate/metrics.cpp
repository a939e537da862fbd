#include "validate/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.h"

namespace etendue {
namespace {

constexpr double kRelativeEpsilon = 0.01;  // of relMSE: keeps dark pixels from deciding everything

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

double luminance(const glm::vec3& rgb) {
  return 0.212671 * static_cast<double>(rgb.x) + 0.715160 * static_cast<double>(rgb.y) +
         0.072169 * static_cast<double>(rgb.z);
}

/// Luma of the display values, which is what SSIM is defined on.
std::vector<double> display_luma(const Image& image) {
  std::vector<double> luma;
  luma.reserve(image.pixels.size());
  for (const glm::vec3& p : image.pixels) {
    luma.push_back(0.2126 * srgb_encode(p.x) + 0.7152 * srgb_encode(p.y) + 0.0722 * srgb_encode(p.z));
  }
  return luma;
}

/// Standard error of the difference of mean luminance; luminance weights are applied as if channels were fully
/// correlated, which they nearly are under white light and which errs on the wide side.
double luminance_error(const Image& image) {
  double variance = 0;
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (!finite(image.pixels[i])) continue;
    const double e = luminance(image.standard_error[i]);
    variance += e * e;
    ++n;
  }
  return n == 0 ? 0.0 : std::sqrt(variance) / static_cast<double>(n);
}

/// Fills mse, rmse, rel_mse, mae, psnr, bias and its interval.
void pixel_metrics(const Image& test, const Image& reference, Metrics& m) {
  double squares = 0, relative = 0, absolute = 0, display_squares = 0, reference_mean = 0;
  RunningMoments difference;
  for (std::size_t i = 0; i < test.pixels.size(); ++i) {
    const glm::vec3 &a = test.pixels[i], &b = reference.pixels[i];
    m.non_finite_test += !finite(a);
    m.non_finite_reference += !finite(b);
    if (!finite(a) || !finite(b)) continue;
    for (int c = 0; c < 3; ++c) {
      const double x = a[c], y = b[c], d = x - y;
      squares += d * d;
      absolute += std::abs(d);
      relative += d * d / (y * y + kRelativeEpsilon);
      const double e = srgb_encode(x) - srgb_encode(y);
      display_squares += e * e;
    }
    difference.add(luminance(a) - luminance(b));
    reference_mean += luminance(b);
  }
  const auto pixels = static_cast<double>(difference.n());
  const double values = std::max(1.0, 3.0 * pixels);
  m.mse = squares / values;
  m.rmse = std::sqrt(m.mse);
  m.rel_mse = relative / values;
  m.mae = absolute / values;
  m.psnr =
      display_squares == 0 ? std::numeric_limits<double>::infinity() : -10.0 * std::log10(display_squares / values);

  m.bias = difference.mean();
  m.bias_from_errors = test.has_statistics() && reference.has_statistics();
  if (m.bias_from_errors) {
    m.bias_interval =
        normal_interval(m.bias, std::hypot(luminance_error(test), luminance_error(reference)), m.bias_level);
  } else {
    m.bias_interval = student_interval(m.bias, difference.standard_error(), pixels - 1, m.bias_level);
  }
  reference_mean /= std::max(1.0, pixels);
  if (reference_mean != 0) {
    m.relative_bias = m.bias / reference_mean;
    m.relative_bias_interval = {m.bias_interval.low / reference_mean, m.bias_interval.high / reference_mean};
  }
}

double mean_of(const std::vector<float>& map) {
  double sum = 0;
  for (const float x : map) sum += x;
  return sum / static_cast<double>(map.size());
}

}  // namespace

void require_comparable(const Image& test, const Image& reference) {
  if (test.width != reference.width || test.height != reference.height) {
    throw Error(ExitCode::usage,
                fmt::format("the pictures differ in size: {}×{} and {}×{} pixels; compare pictures of the "
                            "same size",
                            test.width, test.height, reference.width, reference.height));
  }
  if (test.pixels.empty() || test.pixels.size() != reference.pixels.size()) {
    throw Error(ExitCode::usage, fmt::format("the pictures have {} and {} pixels; there is nothing to compare",
                                             test.pixels.size(), reference.pixels.size()));
  }
}

double srgb_encode(double linear) {
  if (!(linear > 0.0)) return 0.0;  // NaN as well
  if (linear >= 1.0) return 1.0;
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

double srgb_decode(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

Metrics compute_metrics(const Image& test, const Image& reference, const MetricOptions& options) {
  require_comparable(test, reference);
  Metrics m;
  m.bias_level = options.bias_level;
  pixel_metrics(test, reference, m);
  m.ssim = ssim(display_luma(test), display_luma(reference), test.width, test.height);
  m.flip = m.hdr_flip = std::numeric_limits<double>::quiet_NaN();
  if (options.flip) {
    m.flip = mean_of(ldr_flip(test.pixels, reference.pixels, test.width, test.height, options.pixels_per_degree));
    m.hdr_flip = mean_of(hdr_flip(test.pixels, reference.pixels, test.width, test.height, options.pixels_per_degree));
  }
  return m;
}

namespace {

constexpr int kSsimRadius = 5;

/// Gaussian-weighted mean along one axis; positions [first, last) of `size`, windows cut at the border and
/// renormalised.
std::vector<double> window_mean(const std::vector<double>& in, std::uint32_t width, std::uint32_t height,
                                bool along_x) {
  double weights[2 * kSsimRadius + 1];
  for (int i = -kSsimRadius; i <= kSsimRadius; ++i) weights[i + kSsimRadius] = std::exp(-i * i / (2.0 * 1.5 * 1.5));
  std::vector<double> out(in.size());
  const int size = static_cast<int>(along_x ? width : height);
  const std::size_t stride = along_x ? 1 : width;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const int here = static_cast<int>(along_x ? x : y);
      const std::size_t base = along_x ? std::size_t{y} * width : x;
      double sum = 0, norm = 0;
      for (int k = std::max(-kSsimRadius, -here); k <= std::min(kSsimRadius, size - 1 - here); ++k) {
        const double w = weights[k + kSsimRadius];
        sum += w * in[base + static_cast<std::size_t>(here + k) * stride];
        norm += w;
      }
      out[std::size_t{y} * width + x] = sum / norm;
    }
  }
  return out;
}

std::vector<double> window_mean(const std::vector<double>& in, std::uint32_t width, std::uint32_t height) {
  return window_mean(window_mean(in, width, height, true), width, height, false);
}

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] * b[i];
  return out;
}

}  // namespace

double ssim(const std::vector<double>& a, const std::vector<double>& b, std::uint32_t width, std::uint32_t height) {
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  const std::vector<double> mean_a = window_mean(a, width, height), mean_b = window_mean(b, width, height);
  const std::vector<double> aa = window_mean(product(a, a), width, height);
  const std::vector<double> bb = window_mean(product(b, b), width, height);
  const std::vector<double> ab = window_mean(product(a, b), width, height);
  const bool fits = width > 2 * kSsimRadius && height > 2 * kSsimRadius;
  const std::uint32_t border = fits ? kSsimRadius : 0;
  double sum = 0;
  std::uint64_t windows = 0;
  for (std::uint32_t y = border; y < height - border; ++y) {
    for (std::uint32_t x = border; x < width - border; ++x) {
      const std::size_t i = std::size_t{y} * width + x;
      const double variance_a = aa[i] - mean_a[i] * mean_a[i], variance_b = bb[i] - mean_b[i] * mean_b[i];
      const double covariance = ab[i] - mean_a[i] * mean_b[i];
      sum += (2 * mean_a[i] * mean_b[i] + kC1) * (2 * covariance + kC2) /
             ((mean_a[i] * mean_a[i] + mean_b[i] * mean_b[i] + kC1) * (variance_a + variance_b + kC2));
      ++windows;
    }
  }
  return sum / static_cast<double>(windows);
}

}  // namespace etendue
