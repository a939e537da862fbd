// Metrics: cases computed by hand, the papers' constants and invariants, and a second FLIP filter written as one plain
// 2D sum.

#include "validate/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/errors.h"

namespace etendue {
namespace {

constexpr double kPpd = 67.0206432766;
constexpr double kPi = std::numbers::pi;

Image constant(std::uint32_t width, std::uint32_t height, glm::vec3 value) {
  Image image;
  image.width = width;
  image.height = height;
  image.pixels.assign(std::size_t{width} * height, value);
  return image;
}

Image noise(std::uint32_t width, std::uint32_t height, unsigned seed, float scale = 1.0f) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> uniform(0.0f, scale);
  Image image = constant(width, height, {});
  for (glm::vec3& p : image.pixels) p = {uniform(rng), uniform(rng), uniform(rng)};
  return image;
}

MetricOptions without_flip() {
  MetricOptions options;
  options.flip = false;
  return options;
}

TEST(Metrics, HandCase) {
  Image a = constant(2, 1, {1, 1, 1}), b = constant(2, 1, {1, 1, 1});
  a.pixels[0] = {1.5f, 1.0f, 0.5f};
  const Metrics m = compute_metrics(a, b, without_flip());
  EXPECT_DOUBLE_EQ(m.mse, 0.5 / 6);
  EXPECT_DOUBLE_EQ(m.rmse, std::sqrt(0.5 / 6));
  EXPECT_DOUBLE_EQ(m.rel_mse, 0.5 / 1.01 / 6);
  EXPECT_DOUBLE_EQ(m.mae, 1.0 / 6);
  EXPECT_NEAR(m.bias, 0.5 * (0.5 * 0.212671 - 0.5 * 0.072169), 1e-12);
  // Display values: 1.5 is clamped to 1, 0.5 is encoded to 0.735357; only that one differs.
  EXPECT_NEAR(m.psnr, -10 * std::log10((1 - 0.7353569831) * (1 - 0.7353569831) / 6), 1e-6);
}

TEST(Metrics, EqualPicturesHaveNoDistance) {
  const Image a = noise(40, 30, 1);
  const Metrics m = compute_metrics(a, a);
  EXPECT_EQ(m.mse, 0.0);
  EXPECT_EQ(m.rel_mse, 0.0);
  EXPECT_EQ(m.bias, 0.0);
  EXPECT_EQ(m.psnr, std::numeric_limits<double>::infinity());
  EXPECT_NEAR(m.ssim, 1.0, 1e-12);
  EXPECT_EQ(m.flip, 0.0);
  EXPECT_EQ(m.hdr_flip, 0.0);
}

TEST(Metrics, DifferentSizesAreAnError) {
  try {
    compute_metrics(constant(4, 3, {}), constant(3, 4, {}));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::usage);
    EXPECT_NE(std::string(error.what()).find("4×3 and 3×4"), std::string::npos) << error.what();
  }
  EXPECT_THROW(compute_metrics(constant(0, 0, {}), constant(0, 0, {})), Error);
}

TEST(Metrics, NonFinitePixelsAreCountedAndLeftOut) {
  Image a = constant(4, 4, {1, 1, 1}), b = a;
  a.pixels[3].y = std::numeric_limits<float>::quiet_NaN();
  b.pixels[5].x = std::numeric_limits<float>::infinity();
  b.pixels[6].x = 2.0f;
  const Metrics m = compute_metrics(a, b);
  EXPECT_EQ(m.non_finite_test, 1u);
  EXPECT_EQ(m.non_finite_reference, 1u);
  EXPECT_DOUBLE_EQ(m.mse, 1.0 / (3 * 14));
  EXPECT_TRUE(std::isfinite(m.flip));
  EXPECT_TRUE(std::isfinite(m.hdr_flip));
}

TEST(Metrics, BiasIntervalCoversAsOftenAsItSays) {
  std::mt19937 rng(5);
  std::normal_distribution<float> normal(0.0f, 0.1f);
  constexpr std::uint64_t kExperiments = 1000;
  std::uint64_t from_pixels = 0, from_errors = 0;
  for (std::uint64_t i = 0; i < kExperiments; ++i) {
    Image a = constant(8, 8, {1, 1, 1}), b = a;
    for (Image* image : {&a, &b}) {
      for (glm::vec3& p : image->pixels) p = glm::vec3(1.0f + normal(rng));  // grey noise: channels fully correlated
    }
    from_pixels += compute_metrics(a, b, without_flip()).bias_interval.contains(0.0);
    for (Image* image : {&a, &b}) {
      image->standard_error.assign(64, glm::vec3(0.1f));
      image->sample_count.assign(64, 1000);
    }
    const Metrics m = compute_metrics(a, b, without_flip());
    EXPECT_TRUE(m.bias_from_errors);
    from_errors += m.bias_interval.contains(0.0);
  }
  EXPECT_GT(binomial_two_sided(from_pixels, kExperiments, 0.95), 1e-4) << from_pixels;
  EXPECT_GT(binomial_two_sided(from_errors, kExperiments, 0.95), 1e-4) << from_errors;
}

TEST(Srgb, StandardValuesAndInverse) {
  EXPECT_NEAR(srgb_encode(0.0031308), 0.04045, 1e-5);
  EXPECT_NEAR(srgb_encode(0.214041), 0.5, 1e-5);
  EXPECT_EQ(srgb_encode(-1.0), 0.0);
  EXPECT_EQ(srgb_encode(7.0), 1.0);
  EXPECT_EQ(srgb_encode(std::numeric_limits<double>::quiet_NaN()), 0.0);
  for (int i = 0; i < 59; ++i) {
    const double x = 0.001 + 0.017 * i;
    EXPECT_NEAR(srgb_decode(srgb_encode(x)), x, 1e-6);
  }
}

TEST(Ssim, ConstantsHaveAClosedForm) {
  // Without variance: (2ab + C1)/(a² + b² + C1).
  const std::vector<double> a(std::size_t{20} * 20, 0.5), b(std::size_t{20} * 20, 0.25);
  EXPECT_NEAR(ssim(a, b, 20, 20), (0.25 + 1e-4) / (0.3125 + 1e-4), 1e-9);
  EXPECT_NEAR(ssim(a, b, 3, 4), 0, 2) << "smaller than a window: defined all the same";
}

TEST(Ssim, NegativeForInvertedStructureAndSymmetric) {
  std::vector<double> a, inverted;
  for (int i = 0; i < 32 * 32; ++i) {
    a.push_back(((i % 32) + (i / 32)) % 2 ? 0.9 : 0.1);
    inverted.push_back(1.0 - a.back());
  }
  EXPECT_LT(ssim(a, inverted, 32, 32), -0.9);
  EXPECT_DOUBLE_EQ(ssim(a, inverted, 32, 32), ssim(inverted, a, 32, 32));
  const std::vector<double> flat(std::size_t{32} * 32, 0.5);
  EXPECT_LT(ssim(a, flat, 32, 32), 0.05) << "all structure lost";
}

TEST(Ssim, OneWindowByHand) {
  // 11×11: exactly one window fits; weighted moments as one direct double sum.
  std::vector<double> a(121), b(121);
  double w_sum = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
  std::size_t i = 0;
  for (int y = 0; y < 11; ++y) {
    for (int x = 0; x < 11; ++x, ++i) {
      const double va = 0.5 + 0.4 * std::sin(x + 2 * y), vb = 0.5 + 0.4 * std::cos(x * y);
      a[i] = va;
      b[i] = vb;
      const double w = std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / 4.5);
      w_sum += w, ma += w * va, mb += w * vb, aa += w * va * va, bb += w * vb * vb, ab += w * va * vb;
    }
  }
  ma /= w_sum, mb /= w_sum, aa = aa / w_sum - ma * ma, bb = bb / w_sum - mb * mb, ab = ab / w_sum - ma * mb;
  const double expected = (2 * ma * mb + 1e-4) * (2 * ab + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (aa + bb + 9e-4));
  EXPECT_NEAR(ssim(a, b, 11, 11), expected, 1e-12);
}

// --- FLIP
// --------------------------------------------------------------------------------------------------------------

// Every window summed plainly, over a picture of several strips.
TEST(Ssim, StripsLeaveNoSeam) {
  constexpr int kWidth = 20, kHeight = 150;
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> uniform;
  std::vector<double> a(kWidth * kHeight), b(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] = uniform(rng);
    // Least alike around the rows where strips meet, so that a seam would show.
    const double likeness = std::abs(static_cast<double>(i / kWidth % 64) - 5.0) < 6.0 ? 0.1 : 0.9;
    b[i] = likeness * a[i] + (1.0 - likeness) * uniform(rng);
  }
  double total = 0;
  for (int y = 5; y < kHeight - 5; ++y) {
    for (int x = 5; x < kWidth - 5; ++x) {
      double norm = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
      for (int v = -5; v <= 5; ++v) {
        for (int u = -5; u <= 5; ++u) {
          const double w = std::exp(-(u * u + v * v) / 4.5);
          const auto i = static_cast<std::size_t>((y + v) * kWidth + x + u);
          norm += w, ma += w * a[i], mb += w * b[i], aa += w * a[i] * a[i], bb += w * b[i] * b[i],
              ab += w * a[i] * b[i];
        }
      }
      ma /= norm, mb /= norm, aa = aa / norm - ma * ma, bb = bb / norm - mb * mb, ab = ab / norm - ma * mb;
      total += (2 * ma * mb + 1e-4) * (2 * ab + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (aa + bb + 9e-4));
    }
  }
  EXPECT_NEAR(ssim(a, b, kWidth, kHeight), total / ((kWidth - 10) * (kHeight - 10)), 1e-10);
}

TEST(Flip, ColorSpaces) {
  // White is L* = 100 without chroma; YCxCz is (100, 0, 0) there; the way back is the inverse.
  const glm::dvec3 white = flip::ycxcz_from_rgb({1, 1, 1});
  EXPECT_NEAR(white.x, 100.0, 1e-9);
  EXPECT_NEAR(white.y, 0.0, 1e-9);
  EXPECT_NEAR(white.z, 0.0, 1e-9);
  const glm::dvec3 c{0.2, 0.7, 0.4}, back = flip::rgb_from_ycxcz(flip::ycxcz_from_rgb(c));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(back[i], c[i], 1e-12);
  // L*a*b* of the primaries, from tables (D65): green 87.73 −86.18 83.18, blue 32.30 79.19 −107.86; Hunt scales chroma
  // by L/100.
  const glm::dvec3 green = flip::hunt_lab_from_rgb({0, 1, 0}), blue = flip::hunt_lab_from_rgb({0, 0, 1});
  EXPECT_NEAR(green.x, 87.73, 0.01);
  EXPECT_NEAR(green.y, 0.8773 * -86.18, 0.02);
  EXPECT_NEAR(green.z, 0.8773 * 83.18, 0.02);
  EXPECT_NEAR(blue.x, 32.30, 0.01);
  EXPECT_NEAR(blue.y, 0.3230 * 79.19, 0.02);
  EXPECT_NEAR(blue.z, 0.3230 * -107.86, 0.02);
  EXPECT_NEAR(flip::hyab({10, 3, 0}, {4, 0, 4}), 6 + 5, 1e-12);
}

TEST(Flip, RedistributionHasTheKneeOfThePaper) {
  const double largest = flip::hyab(flip::hunt_lab_from_rgb({0, 1, 0}), flip::hunt_lab_from_rgb({0, 0, 1}));
  EXPECT_NEAR(std::pow(largest, 0.7), 41.28, 0.01);
  EXPECT_EQ(flip::redistribute(0.0), 0.0);
  EXPECT_NEAR(flip::redistribute(largest), 1.0, 1e-12);
  const double knee = std::pow(0.4 * std::pow(largest, 0.7), 1.0 / 0.7);
  EXPECT_NEAR(flip::redistribute(knee), 0.95, 1e-12);
  EXPECT_NEAR(flip::redistribute(knee * std::pow(0.5, 1.0 / 0.7)), 0.475, 1e-12);
}

TEST(Flip, ConstantColorsNeedNoFilter) {
  // No features and nothing to blur: the value is the redistributed distance itself.
  const glm::vec3 a{0.2f, 0.5f, 0.1f}, b{0.25f, 0.45f, 0.3f};
  const double expected =
      flip::redistribute(flip::hyab(flip::hunt_lab_from_rgb(glm::dvec3(a)), flip::hunt_lab_from_rgb(glm::dvec3(b))));
  const std::vector<float> map = ldr_flip(constant(30, 20, a).pixels, constant(30, 20, b).pixels, 30, 20, kPpd);
  for (const float x : map) EXPECT_NEAR(x, expected, 1e-4);
  // Black against white: 100^0.7 = 25.12, beyond the knee at 16.51.
  const std::vector<float> bw = ldr_flip(constant(9, 9, {}).pixels, constant(9, 9, {1, 1, 1}).pixels, 9, 9, kPpd);
  EXPECT_NEAR(bw[40], 0.95 + (25.1189 - 16.5104) / (41.2760 - 16.5104) * 0.05, 1e-4);
}

TEST(Flip, InvariantsOfAMetric) {
  const Image a = noise(40, 32, 1), b = noise(40, 32, 2);
  const auto ab = ldr_flip(a.pixels, b.pixels, 40, 32, kPpd), ba = ldr_flip(b.pixels, a.pixels, 40, 32, kPpd);
  for (std::size_t i = 0; i < ab.size(); ++i) {
    EXPECT_EQ(ab[i], ba[i]);
    EXPECT_GE(ab[i], 0.0f);
    EXPECT_LE(ab[i], 1.0f);
  }
  // A mirrored pair has the mirrored map.
  const auto mirror = [](const Image& image) {
    auto out = image.pixels;
    for (auto row = out.begin(); row != out.end(); row += image.width) std::reverse(row, row + image.width);
    return out;
  };
  const auto mirrored = ldr_flip(mirror(a), mirror(b), 40, 32, kPpd);
  for (std::uint32_t y = 0; y < 32; ++y) {
    for (std::uint32_t x = 0; x < 40; ++x) EXPECT_NEAR(mirrored[y * 40 + x], ab[y * 40 + 39 - x], 1e-4);
  }
}

// The whole of section 4 at one pixel as plain 2D sums over the unseparated filters.
double flip_at(const Image& a, const Image& b, int px, int py) {
  const auto at = [&](const Image& image, int x, int y) {
    const auto column = static_cast<std::size_t>(std::clamp(x, 0, int(image.width) - 1));
    const auto row = static_cast<std::size_t>(std::clamp(y, 0, int(image.height) - 1));
    return flip::ycxcz_from_rgb(glm::dvec3(image.pixels[row * image.width + column]));
  };
  const int r = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * kPpd));
  glm::dvec3 seen[2];
  double edge[2], point[2];
  for (int k = 0; k < 2; ++k) {
    const Image& image = k == 0 ? a : b;
    glm::dvec3 sum(0), norm(0);
    for (int y = -r; y <= r; ++y) {
      for (int x = -r; x <= r; ++x) {
        const double d2 = (x * x + y * y) / (kPpd * kPpd);
        const auto g = [&](double s, double t) { return s * std::sqrt(kPi / t) * std::exp(-kPi * kPi * d2 / t); };
        const glm::dvec3 w(g(1, 0.0047), g(1, 0.0053), g(34.1, 0.04) + g(13.5, 0.025));
        sum += w * at(image, px + x, py + y);
        norm += w;
      }
    }
    seen[k] = flip::hunt_lab_from_rgb(glm::clamp(flip::rgb_from_ycxcz(sum / norm), 0.0, 1.0));
    const double sigma = 0.5 * 0.082 * kPpd;
    const int q = static_cast<int>(std::ceil(3 * sigma));
    double ex = 0, ey = 0, dx = 0, dy = 0, e_norm = 0, d_plus = 0, d_minus = 0;
    for (int y = -q; y <= q; ++y) {
      for (int x = -q; x <= q; ++x) {
        const double g = std::exp(-(x * x + y * y) / (2 * sigma * sigma)), d = (x * x / (sigma * sigma) - 1) * g;
        if (x < 0) e_norm += -x * g;
        (d > 0 ? d_plus : d_minus) += std::abs(d);
      }
    }
    for (int y = -q; y <= q; ++y) {
      for (int x = -q; x <= q; ++x) {
        const double g = std::exp(-(x * x + y * y) / (2 * sigma * sigma)), v = (at(image, px + x, py + y).x + 16) / 116;
        const double sx = (x * x / (sigma * sigma) - 1) * g, sy = (y * y / (sigma * sigma) - 1) * g;
        ex += -x * g / e_norm * v, ey += -y * g / e_norm * v;
        dx += sx / (sx > 0 ? d_plus : d_minus) * v, dy += sy / (sy > 0 ? d_plus : d_minus) * v;
      }
    }
    edge[k] = std::hypot(ex, ey), point[k] = std::hypot(dx, dy);
  }
  const double feature =
      std::sqrt(std::max(std::abs(edge[0] - edge[1]), std::abs(point[0] - point[1])) / std::sqrt(2.0));
  return std::pow(flip::redistribute(flip::hyab(seen[0], seen[1])), 1 - feature);
}

TEST(Flip, AgreesWithThePlainSums) {
  const Image a = noise(40, 32, 3), b = noise(40, 32, 4, 0.8f);
  const auto map = ldr_flip(a.pixels, b.pixels, 40, 32, kPpd);
  for (const auto& [x, y] : {std::pair{20, 16}, {0, 0}, {39, 5}, {7, 31}}) {
    EXPECT_NEAR(map[static_cast<std::size_t>(y * 40 + x)], flip_at(a, b, x, y), 1e-4) << x << ", " << y;
  }
}

// Large pictures are computed in strips of rows; nothing may show where they meet.
TEST(Flip, StripsLeaveNoSeam) {
  const Image a = noise(24, 150, 3), b = noise(24, 150, 4, 0.8f);
  const auto map = ldr_flip(a.pixels, b.pixels, 24, 150, kPpd);
  for (const int y : {62, 63, 64, 65, 127, 128, 149}) {
    EXPECT_NEAR(map[static_cast<std::size_t>(y * 24 + 9)], flip_at(a, b, 9, y), 1e-4) << y;
  }
  double sum = 0;
  for (const float x : map) sum += static_cast<double>(x);
  EXPECT_NEAR(mean_ldr_flip(a.pixels, b.pixels, 24, 150, kPpd), sum / static_cast<double>(map.size()), 1e-12);
}

TEST(HdrFlip, ExposuresBracketTheReference) {
  // Half of the pixels at 1, the brightest at 256: eight stops apart.
  Image reference = constant(10, 10, {1, 1, 1});
  reference.pixels[0] = {256, 256, 256};
  const std::vector<double> exposures = hdr_flip_exposures(reference.pixels);
  ASSERT_EQ(exposures.size(), 8u);
  EXPECT_NEAR(exposures.back() - exposures.front(), 8.0, 1e-5);
  // By definition the brightest and the median show as 0.85.
  EXPECT_NEAR(flip::tone_map(256 * std::exp2(exposures.front())), 0.85, 1e-4);
  EXPECT_NEAR(flip::tone_map(std::exp2(exposures.back())), 0.85, 1e-4);
  EXPECT_EQ(hdr_flip_exposures(constant(4, 4, {}).pixels).size(), 2u);
  EXPECT_EQ(hdr_flip_exposures(constant(4, 4, {1, 1, 1}).pixels).size(), 2u);
}

TEST(HdrFlip, SeesWhatClampingHides) {
  Image a = constant(24, 24, {0.5f, 0.5f, 0.5f}), b = a;
  for (std::size_t i = 0; i < 5; ++i) a.pixels[12 * 24 + 8 + i] = glm::vec3(50.0f);
  for (std::size_t i = 0; i < 5; ++i) b.pixels[12 * 24 + 8 + i] = glm::vec3(10.0f);
  const auto ldr = ldr_flip(a.pixels, b.pixels, 24, 24, kPpd), hdr = hdr_flip(a.pixels, b.pixels, 24, 24, kPpd);
  EXPECT_EQ(*std::max_element(ldr.begin(), ldr.end()), 0.0f);
  EXPECT_GT(*std::max_element(hdr.begin(), hdr.end()), 0.1f);
  // A common factor changes nothing: exposures follow the reference.
  auto a4 = a.pixels, b4 = b.pixels;
  for (auto* picture : {&a4, &b4}) {
    for (glm::vec3& p : *picture) p *= 4.0f;
  }
  const auto scaled = hdr_flip(a4, b4, 24, 24, kPpd);
  for (std::size_t i = 0; i < hdr.size(); ++i) EXPECT_NEAR(scaled[i], hdr[i], 1e-4);
}

}  // namespace
}  // namespace etendue
