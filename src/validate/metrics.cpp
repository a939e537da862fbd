#include "validate/metrics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/parallel.h"
#include "image/vectors.h"

namespace etendue {
namespace {

constexpr double kRelativeEpsilon = 0.01;  // of relMSE: keeps dark pixels from deciding everything

bool finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Luma of the display values, which is what SSIM is defined on.
double display_luma(const glm::vec3& p) {
  return 0.2126 * srgb_encode(p.x) + 0.7152 * srgb_encode(p.y) + 0.0722 * srgb_encode(p.z);
}

/// Standard error of the difference of mean luminance; luminance weights are applied as if channels were fully
/// correlated, which they nearly are under white light and which errs on the wide side. Infinite when one is unknown.
double luminance_error(const Image& image) {
  double variance = 0;
  std::uint64_t n = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (!finite(image.pixels[i])) continue;
    const double e = luminance(image.standard_error[i]);
    if (std::isnan(e)) return std::numeric_limits<double>::infinity();
    variance += e * e;
    ++n;
  }
  return n == 0 ? 0.0 : std::sqrt(variance) / static_cast<double>(n);
}

/// Sums over some of the pixels.
struct PixelSums {
  double squares = 0, relative = 0, absolute = 0, display_squares = 0, reference = 0;
  std::uint64_t non_finite_test = 0, non_finite_reference = 0;
  RunningMoments difference;  ///< of the luminance

  void add(const glm::vec3& a, const glm::vec3& b) {
    non_finite_test += !finite(a);
    non_finite_reference += !finite(b);
    if (!finite(a) || !finite(b)) return;
    for (int c = 0; c < 3; ++c) {
      const double x = a[c], y = b[c], d = x - y;
      squares += d * d;
      absolute += std::abs(d);
      relative += d * d / (y * y + kRelativeEpsilon);
      const double e = x == y ? 0.0 : srgb_encode(x) - srgb_encode(y);
      display_squares += e * e;
    }
    difference.add(luminance(a) - luminance(b));
    reference += luminance(b);
  }
  void merge(const PixelSums& other) {
    squares += other.squares;
    relative += other.relative;
    absolute += other.absolute;
    display_squares += other.display_squares;
    reference += other.reference;
    non_finite_test += other.non_finite_test;
    non_finite_reference += other.non_finite_reference;
    difference.merge(other.difference);
  }
};

/// Pieces of fixed size, put together in order: the same numbers for any number of threads.
PixelSums sum_pixels(const Image& test, const Image& reference) {
  constexpr std::size_t kPiece = 1 << 16;
  const std::size_t pixels = test.pixels.size();
  std::vector<PixelSums> pieces((pixels + kPiece - 1) / kPiece);
  parallel_for(pieces.size(), 1, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::size_t i = begin * kPiece; i < std::min<std::size_t>(end * kPiece, pixels); ++i)
      pieces[i / kPiece].add(test.pixels[i], reference.pixels[i]);
  });
  PixelSums all;
  for (const PixelSums& piece : pieces) all.merge(piece);
  return all;
}

/// Fills mse, rmse, rel_mse, mae, psnr, bias and its interval.
void pixel_metrics(const Image& test, const Image& reference, Metrics& m) {
  const PixelSums sums = sum_pixels(test, reference);
  m.non_finite_test = sums.non_finite_test;
  m.non_finite_reference = sums.non_finite_reference;
  const auto pixels = static_cast<double>(sums.difference.n());
  const double values = std::max(1.0, 3.0 * pixels);
  m.mse = sums.squares / values;
  m.rmse = std::sqrt(m.mse);
  m.rel_mse = sums.relative / values;
  m.mae = sums.absolute / values;
  m.psnr = sums.display_squares == 0 ? std::numeric_limits<double>::infinity()
                                     : -10.0 * std::log10(sums.display_squares / values);

  m.bias = sums.difference.mean();
  m.bias_from_errors = test.has_statistics() && reference.has_statistics();
  if (m.bias_from_errors) {
    m.bias_interval =
        normal_interval(m.bias, std::hypot(luminance_error(test), luminance_error(reference)), m.bias_level);
  } else {
    m.bias_interval = student_interval(m.bias, sums.difference.standard_error(), pixels - 1, m.bias_level);
  }
  const double reference_mean = sums.reference / std::max(1.0, pixels);
  if (reference_mean != 0) {
    m.relative_bias = m.bias / reference_mean;
    m.relative_bias_interval = {m.bias_interval.low / reference_mean, m.bias_interval.high / reference_mean};
  }
}

}  // namespace

void require_same_size(std::uint32_t test_width, std::uint32_t test_height, std::uint32_t reference_width,
                       std::uint32_t reference_height) {
  if (test_width == reference_width && test_height == reference_height) return;
  throw Error(ErrorKind::usage,
              fmt::format("the pictures differ in size: {}×{} and {}×{} pixels; compare pictures of the same size",
                          test_width, test_height, reference_width, reference_height));
}

void require_comparable(const Image& test, const Image& reference) {
  require_same_size(test.width, test.height, reference.width, reference.height);
  if (test.pixels.empty() || test.pixels.size() != reference.pixels.size()) {
    throw Error(ErrorKind::usage, fmt::format("the pictures have {} and {} pixels; there is nothing to compare",
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
  m.ssim = mean_ssim(test, reference);
  m.flip = m.hdr_flip = std::numeric_limits<double>::quiet_NaN();
  if (options.flip)
    m.flip = mean_ldr_flip(test.pixels, reference.pixels, test.width, test.height, options.pixels_per_degree);
  if (options.flip && options.hdr_flip)
    m.hdr_flip = mean_hdr_flip(test.pixels, reference.pixels, test.width, test.height, options.pixels_per_degree);
  return m;
}

namespace {

constexpr int kSsimRadius = 5;

using SsimWindow = std::array<double, 2 * kSsimRadius + 1>;

const SsimWindow& ssim_window() {
  static const SsimWindow weights = [] {
    SsimWindow w{};
    for (int i = -kSsimRadius; i <= kSsimRadius; ++i)
      w[static_cast<std::size_t>(i + kSsimRadius)] = std::exp(-i * i / (2.0 * 1.5 * 1.5));
    return w;
  }();
  return weights;
}

/// Places i, i + k of a window's weight k within `size`: first and one past the last i.
std::pair<int, int> reach(int k, int size) {
  return {std::max(0, -k), size - std::max(0, k)};
}

/// Sums of the weights of windows that are cut at the borders, by place.
std::vector<double> window_sums(int size) {
  std::vector<double> sums(static_cast<std::size_t>(size), 0.0);
  for (int k = -kSsimRadius; k <= kSsimRadius; ++k) {
    const auto [begin, end] = reach(k, size);
    for (int i = begin; i < end; ++i)
      sums[static_cast<std::size_t>(i)] += ssim_window()[static_cast<std::size_t>(k + kSsimRadius)];
  }
  return sums;
}

/// Adds `weight` times a run of values: loops that compilers vectorise, because nothing in them depends on the place.
void add_scaled(const double* in, double weight, std::size_t count, double* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] += weight * in[i];
}

/// Gaussian-weighted mean along one axis, windows cut at the border and renormalised.
std::vector<double> window_mean(const std::vector<double>& in, std::uint32_t width, std::uint32_t height,
                                bool along_x) {
  std::vector<double> out(in.size(), 0.0);
  const std::vector<double> sums = window_sums(static_cast<int>(along_x ? width : height));
  for (std::uint32_t y = 0; y < height; ++y) {
    double* row = &out[std::size_t{y} * width];
    for (int k = -kSsimRadius; k <= kSsimRadius; ++k) {
      const double weight = ssim_window()[static_cast<std::size_t>(k + kSsimRadius)];
      const auto [begin, end] = reach(k, static_cast<int>(along_x ? width : height));
      if (along_x) {
        if (begin < end)
          add_scaled(&in[std::size_t{y} * width] + begin + k, weight, static_cast<std::size_t>(end - begin),
                     row + begin);
      } else if (static_cast<int>(y) >= begin && static_cast<int>(y) < end) {
        add_scaled(&in[static_cast<std::size_t>(static_cast<int>(y) + k) * width], weight, width, row);
      }
    }
    for (std::uint32_t x = 0; x < width; ++x) row[x] /= sums[along_x ? x : y];
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

namespace {

/// Sum of the structural similarity over the windows around the rows [y0, y1) of two strips of `rows` rows.
double ssim_sum(const std::vector<double>& a, const std::vector<double>& b, std::uint32_t width, std::uint32_t rows,
                std::uint32_t y0, std::uint32_t y1, std::uint32_t border) {
  if (a == b) return static_cast<double>(y1 - y0) * (width - 2 * border);  // each window gives exactly 1
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  const std::vector<double> mean_a = window_mean(a, width, rows), mean_b = window_mean(b, width, rows);
  const std::vector<double> aa = window_mean(product(a, a), width, rows);
  const std::vector<double> bb = window_mean(product(b, b), width, rows);
  const std::vector<double> ab = window_mean(product(a, b), width, rows);
  double sum = 0;
  for (std::uint32_t y = y0; y < y1; ++y) {
    for (std::uint32_t x = border; x < width - border; ++x) {
      const std::size_t i = std::size_t{y} * width + x;
      const double variance_a = aa[i] - mean_a[i] * mean_a[i], variance_b = bb[i] - mean_b[i] * mean_b[i];
      const double covariance = ab[i] - mean_a[i] * mean_b[i];
      sum += (2 * mean_a[i] * mean_b[i] + kC1) * (2 * covariance + kC2) /
             ((mean_a[i] * mean_a[i] + mean_b[i] * mean_b[i] + kC1) * (variance_a + variance_b + kC2));
    }
  }
  return sum;
}

/// In strips of rows with the rows that their windows reach, so that memory does not grow with the picture.
/// `rows(first, last)` gives the values of these rows of both pictures.
template <typename Rows>
double ssim_in_strips(std::uint32_t width, std::uint32_t height, const Rows& rows) {
  constexpr std::uint32_t kRows = 64;
  const bool fits = width > 2 * kSsimRadius && height > 2 * kSsimRadius;
  const std::uint32_t border = fits ? kSsimRadius : 0;
  const std::uint32_t lines = height - 2 * border;
  std::vector<double> sums((lines + kRows - 1) / kRows, 0.0);
  parallel_for(sums.size(), 1, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t strip = begin; strip < end; ++strip) {
      const std::uint32_t y0 = border + static_cast<std::uint32_t>(strip) * kRows;
      const std::uint32_t y1 = std::min(y0 + kRows, border + lines);
      const std::uint32_t first = y0 - std::min<std::uint32_t>(y0, kSsimRadius);
      const std::uint32_t last = std::min<std::uint32_t>(y1 + kSsimRadius, height);
      const auto [a, b] = rows(first, last);
      sums[strip] = ssim_sum(a, b, width, last - first, y0 - first, y1 - first, border);
    }
  });
  double sum = 0;
  for (const double part : sums) sum += part;
  return sum / (static_cast<double>(lines) * (width - 2 * border));
}

}  // namespace

double ssim(const std::vector<double>& a, const std::vector<double>& b, std::uint32_t width, std::uint32_t height) {
  const auto part = [width](const std::vector<double>& all, std::uint32_t first, std::uint32_t last) {
    const auto row = [&](std::uint32_t y) { return all.begin() + static_cast<std::ptrdiff_t>(y) * width; };
    return std::vector<double>(row(first), row(last));
  };
  return ssim_in_strips(width, height, [&](std::uint32_t first, std::uint32_t last) {
    return std::pair(part(a, first, last), part(b, first, last));
  });
}

double mean_ssim(const Image& test, const Image& reference) {
  const auto luma = [](const Image& image, std::uint32_t first, std::uint32_t last) {
    std::vector<double> out;
    out.reserve(std::size_t{last - first} * image.width);
    for (std::size_t i = std::size_t{first} * image.width; i < std::size_t{last} * image.width; ++i)
      out.push_back(display_luma(image.pixels[i]));
    return out;
  };
  return ssim_in_strips(test.width, test.height, [&](std::uint32_t first, std::uint32_t last) {
    return std::pair(luma(test, first, last), luma(reference, first, last));
  });
}

}  // namespace etendue
