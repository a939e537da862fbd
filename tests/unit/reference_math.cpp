/// The parts below the renderer: random words, warps, materials, filters, choices, camera.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "reference/bsdf.h"
#include "reference/camera.h"
#include "reference/filter.h"
#include "reference/fresnel.h"
#include "reference/lights.h"
#include "reference/rng.h"
#include "reference/sampling.h"
#include "reference_scenes.h"

namespace etendue::reference::test {
namespace {

/// (χ² − k) / √(2k) of counts that should be equal: about a standard normal variable for many bins.
double chi2_z(const std::vector<double>& counts) {
  double n = 0.0;
  for (const double c : counts) n += c;
  const double expected = n / static_cast<double>(counts.size());
  double chi2 = 0.0;
  for (const double c : counts) chi2 += (c - expected) * (c - expected) / expected;
  const double k = static_cast<double>(counts.size()) - 1.0;
  return (chi2 - k) / std::sqrt(2.0 * k);
}
/// χ² has a heavier upper tail than the normal; 6 is about 1e-7 at 255 degrees of freedom.
constexpr double kMaxChi2Z = 6.0;

/// 16 × 16 histogram of points that should be uniform on the unit square.
template <class Point>
std::vector<double> histogram(int n, const Point& point) {
  std::mt19937_64 random(99);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  std::vector<double> counts(256, 0.0);
  for (int i = 0; i < n; ++i) {
    const double ux = u(random), uy = u(random);
    const Vec2 p = point(Vec2(ux, uy));
    EXPECT_TRUE(p.x >= 0.0 && p.x <= 1.0 && p.y >= 0.0 && p.y <= 1.0) << p.x << ' ' << p.y;
    const int x = std::clamp(static_cast<int>(16 * p.x), 0, 15), y = std::clamp(static_cast<int>(16 * p.y), 0, 15);
    counts[16 * y + x] += 1.0;
  }
  return counts;
}
double turn(double y, double x) {
  return std::atan2(y, x) / (2.0 * kPi) + 0.5;
}

Vec3 random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> g;
  const double x = g(random), y = g(random), z = g(random);
  return glm::normalize(Vec3(x, y, z));
}

TEST(ReferenceRandom, KnownWords) {
  using Words = std::array<std::uint32_t, 4>;
  // Computed with an independent implementation of the published listing.
  EXPECT_EQ(pcg4d({0, 0, 0, 0}), (Words{0xf02f829u, 0x2d568769u, 0x32b0c43bu, 0xd32548eau}));
  EXPECT_EQ(pcg4d({1, 2, 3, 4}), (Words{0x3622cd16u, 0xf11471d8u, 0xe1109b3fu, 0x2b94c2fu}));
  EXPECT_EQ(pcg4d({0xffffffffu, 7, 0x80000000u, 12345}), (Words{0xef915379u, 0xd05f9fcbu, 0x52c5ef09u, 0xeadb4cc0u}));
}

TEST(ReferenceRandom, FloatsAreInHalfOpenInterval) {
  EXPECT_EQ(unit_float(0), 0.0);
  EXPECT_EQ(unit_float(0xffffffffu), 1.0 - 0x1p-24);
  EXPECT_EQ(unit_float(0x80000000u), 0.5);
}

TEST(ReferenceRandom, BlocksAndNumbersAreWhereTheConventionsPutThem) {
  const SampleRandom random(4, 1, 2);  // block 3 is the light block of k = 1
  const auto words = pcg4d({1, 2, 3, 4});
  const auto light = random.light(1);
  EXPECT_EQ(light.emitter, words[0]);
  EXPECT_EQ(light.primitive, words[1]);
  EXPECT_EQ(light.u, unit_float(words[2]));
  EXPECT_EQ(light.v, unit_float(words[3]));
  const auto words4 = pcg4d({1, 2, 4, 4});
  const auto material = random.material(1);
  EXPECT_EQ(material.lobe, unit_float(words4[0]));
  EXPECT_EQ(material.u, unit_float(words4[1]));
  EXPECT_EQ(material.v, unit_float(words4[2]));
  EXPECT_EQ(material.roulette, unit_float(words4[3]));
  EXPECT_EQ(random.filter().x, unit_float(pcg4d({1, 2, 0, 4})[0]));
  EXPECT_EQ(random.filter().y, unit_float(pcg4d({1, 2, 0, 4})[1]));
}

TEST(ReferenceRandom, ConsecutiveSamplesAndBlocksAreUniformTogether) {
  for (int pair = 0; pair < 4; ++pair) {
    std::vector<double> counts(256, 0.0);
    for (std::uint32_t s = 0; s < 200000; ++s) {
      const SampleRandom a(3, 17, s), b(3, 17, s + 1), c(3, 18, s), d(4, 17, s);
      const double x = a.material(0).u;
      const double y = pair == 0   ? a.material(0).v
                       : pair == 1 ? b.material(0).u
                       : pair == 2 ? c.material(0).u
                                   : d.material(0).u;
      counts[16 * static_cast<int>(16 * y) + static_cast<int>(16 * x)] += 1.0;
    }
    EXPECT_LT(std::abs(chi2_z(counts)), kMaxChi2Z) << pair;
  }
}

TEST(ReferenceFrame, IsOrthonormalAndRightHanded) {
  std::mt19937_64 random(1);
  std::vector<Vec3> normals{{0, 0, 1},  {0, 0, -1},   {1, 0, 0},
                            {0, -1, 0}, {1, 0, -0.0}, glm::normalize(Vec3(1e-9, -1e-9, -1))};
  for (int i = 0; i < 10000; ++i) normals.push_back(random_direction(random));
  for (const Vec3& n : normals) {
    const Frame frame(n);
    const Vec3 s = frame.to_world({1, 0, 0}), t = frame.to_world({0, 1, 0});
    EXPECT_EQ(frame.to_world({0, 0, 1}), n);
    EXPECT_NEAR(glm::dot(s, s), 1.0, 1e-14);
    EXPECT_NEAR(glm::dot(t, t), 1.0, 1e-14);
    EXPECT_NEAR(glm::dot(s, t), 0.0, 1e-14);
    EXPECT_LT(glm::length(glm::cross(s, t) - n), 1e-14);
    EXPECT_LT(glm::length(frame.to_local(frame.to_world({0.2, -0.3, 0.4})) - Vec3(0.2, -0.3, 0.4)), 1e-14);
  }
}

TEST(ReferenceWarps, AreUniformInTheirMeasure) {
  constexpr int n = 200000;
  const auto disk = histogram(n, [](const Vec2& u) {
    const Vec2 p = square_to_disk(u);
    return Vec2(glm::dot(p, p), turn(p.y, p.x));
  });
  EXPECT_LT(std::abs(chi2_z(disk)), kMaxChi2Z);
  const auto hemisphere = histogram(n, [](const Vec2& u) {
    const Vec3 w = square_to_cosine_hemisphere(u);
    EXPECT_NEAR(glm::length(w), 1.0, 1e-14);
    return Vec2(w.z * w.z, turn(w.y, w.x));  // cumulative of 2 cos sin
  });
  EXPECT_LT(std::abs(chi2_z(hemisphere)), kMaxChi2Z);
  const auto tri = histogram(n, [](const Vec2& u) {
    const Vec3 b = square_to_triangle(u);
    EXPECT_NEAR(b.x + b.y + b.z, 1.0, 1e-14);
    // Independent inverse: the share of the triangle beyond b0, and where b1 lies along that line.
    return Vec2((1 - b.x) * (1 - b.x), b.x < 1.0 ? std::min(1.0, b.y / (1 - b.x)) : 0.0);
  });
  EXPECT_LT(std::abs(chi2_z(tri)), kMaxChi2Z);
  for (const double radius : {0.999, 0.5, 1e-6}) {
    const SphereCone cone(radius, 1.0);
    const auto counts = histogram(n, [&](const Vec2& u) {
      const Vec3 w = cone.sample(u);
      const double sin2 = w.x * w.x + w.y * w.y;
      return Vec2(std::min(1.0, sin2 / (1.0 + w.z) / cone.one_minus_cos_max), turn(w.y, w.x));
    });
    EXPECT_LT(std::abs(chi2_z(counts)), kMaxChi2Z) << radius;
  }
}

TEST(ReferenceWarps, NoDirectionLiesInTheSurface) {
  const double last = 1.0 - 0x1p-24;
  for (const Vec2& u : {Vec2(0, 0), Vec2(0, 0.3), Vec2(0.7, 0), Vec2(last, 0.5), Vec2(0.5, last), Vec2(last, last)})
    EXPECT_NEAR(square_to_cosine_hemisphere(u).z, 0x1p-11 * std::sqrt(0.5), 1e-9) << u.x << ", " << u.y;
}

TEST(ReferenceWarps, ANonUniformMapIsFound) {
  // Negative control: radius u instead of √u.
  const auto wrong = histogram(200000, [](const Vec2& u) { return Vec2(u.x * u.x, u.y); });
  EXPECT_GT(chi2_z(wrong), kMaxChi2Z);
}

TEST(ReferenceWarps, ConePdfIsOneOverItsSolidAngle) {
  EXPECT_NEAR(1.0 / SphereCone(0.5, 1.0).pdf_w(), 2.0 * kPi * (1.0 - std::sqrt(0.75)), 1e-14);
  EXPECT_NEAR(1.0 / SphereCone(1.0, 1.0).pdf_w(), 2.0 * kPi, 1e-14);
  // Far away the solid angle is that of a disk, to all digits.
  EXPECT_NEAR(1.0 / SphereCone(1e-9, 1.0).pdf_w() / (kPi * 1e-18), 1.0, 1e-12);
}

TEST(ReferenceFresnel, KnownValues) {
  for (const double n : {1.0, 1.31, 1.5046, 2.4}) {
    const double r = (n - 1) / (n + 1);
    EXPECT_NEAR(fresnel_dielectric(1.0, 1.0, n).reflectance, r * r, 1e-15);
    EXPECT_NEAR(fresnel_dielectric(1.0, n, 1.0).reflectance, r * r, 1e-15);
  }
  // At Brewster's angle only the perpendicular component is left: (cos² − sin²)² / 2.
  const double n = 1.5, brewster = std::atan(n);
  EXPECT_NEAR(fresnel_dielectric(std::cos(brewster), 1.0, n).reflectance, 0.5 * std::pow(std::cos(2 * brewster), 2),
              1e-14);
  EXPECT_NEAR(fresnel_dielectric(1e-9, 1.0, n).reflectance, 1.0, 1e-7);
  const double critical = std::asin(1.0 / n);
  EXPECT_EQ(fresnel_dielectric(std::cos(critical + 1e-6), n, 1.0).reflectance, 1.0);
  EXPECT_LT(fresnel_dielectric(std::cos(critical - 1e-3), n, 1.0).reflectance, 0.9);
}

TEST(ReferenceFresnel, IsTheSameFromBothSides) {
  for (int i = 1; i < 100; ++i) {
    const double c = 0.01 * i;
    const Fresnel in = fresnel_dielectric(c, 1.0, 1.7);
    const Fresnel out = fresnel_dielectric(in.cos_transmitted, 1.7, 1.0);
    EXPECT_NEAR(in.reflectance, out.reflectance, 1e-12);
    EXPECT_NEAR(out.cos_transmitted, c, 1e-12);
    EXPECT_NEAR(std::sqrt(1 - c * c), 1.7 * std::sqrt(1 - in.cos_transmitted * in.cos_transmitted), 1e-12);
  }
}

TEST(ReferenceBsdf, DiffuseKeepsItsContract) {
  const Bsdf bsdf = DiffuseBsdf{.albedo = {0.2, 0.5, 0.9}};
  const Vec3 wo = glm::normalize(Vec3(0.3, -0.2, 0.5));
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (int i = 0; i < 1000; ++i) {
    const double ux = u(random), uy = u(random);
    const BsdfSample s = sample(bsdf, wo, 0.0, {ux, uy});
    ASSERT_EQ(s.lobe, Lobe::diffuse_reflection);
    EXPECT_NEAR(s.pdf, pdf(bsdf, wo, s.wi), 1e-15);
    EXPECT_LT(glm::length(s.weight * s.pdf - eval(bsdf, wo, s.wi)), 1e-14);
  }
  // ∫ pdf dω = 1 and ∫ eval dω = albedo, by the midpoint rule in z = cos θ.
  double density = 0.0;
  Vec3 reflected(0.0);
  for (int i = 0; i < 1000; ++i) {
    const double z = (i + 0.5) / 1000;
    const Vec3 wi(std::sqrt(1 - z * z), 0.0, z);
    density += pdf(bsdf, wo, wi) * 2 * kPi / 1000;
    reflected += eval(bsdf, wo, wi) * (2 * kPi / 1000);
  }
  EXPECT_NEAR(density, 1.0, 1e-9);
  EXPECT_LT(glm::length(reflected - Vec3(0.2, 0.5, 0.9)), 1e-9);
  EXPECT_EQ(eval(bsdf, -wo, {0, 0, 1}), Vec3(0.0));
  EXPECT_EQ(eval(bsdf, wo, {0, 0, -1}), Vec3(0.0));
  EXPECT_EQ(sample(bsdf, -wo, 0.0, {0.5, 0.5}).lobe, Lobe::none);
}

TEST(ReferenceBsdf, MirrorReflectsOnItsFrontOnly) {
  const Vec3 wo = glm::normalize(Vec3(0.3, -0.2, 0.5));
  const BsdfSample s = sample(Bsdf(MirrorBsdf{}), wo, 0.3, {0.1, 0.2});
  EXPECT_EQ(s.wi, Vec3(-wo.x, -wo.y, wo.z));
  EXPECT_EQ(s.weight, Vec3(1.0));
  EXPECT_EQ(s.lobe, Lobe::delta_reflection);
  EXPECT_EQ(sample(Bsdf(MirrorBsdf{}), -wo, 0.3, {0.1, 0.2}).lobe, Lobe::none);
}

TEST(ReferenceBsdf, DielectricSharesEnergyByFresnelAndBendsBySnell) {
  const DielectricBsdf glass{.int_ior = 1.5, .ext_ior = 1.1};
  for (const double cosine : {1.0, 0.7, 0.2, -0.2, -0.8, -1.0}) {
    const Vec3 wo(std::sqrt(1 - cosine * cosine), 0.0, cosine);
    const double n_o = cosine > 0 ? 1.1 : 1.5, n_i = cosine > 0 ? 1.5 : 1.1;
    const double reflectance = fresnel_dielectric(std::abs(cosine), n_o, n_i).reflectance;
    int reflected = 0;
    constexpr int n = 4096;
    for (int i = 0; i < n; ++i) {
      const BsdfSample s = sample(glass, wo, (i + 0.5) / n, {0, 0});
      EXPECT_NEAR(glm::length(s.wi), 1.0, 1e-14);
      if (s.lobe == Lobe::delta_reflection) {
        ++reflected;
        EXPECT_EQ(s.wi, Vec3(-wo.x, -wo.y, wo.z));
        EXPECT_EQ(s.weight, Vec3(1.0));
        EXPECT_EQ(s.pdf, reflectance);
      } else {
        EXPECT_LT(s.wi.z * wo.z, 0.0);
        EXPECT_NEAR(n_i * s.wi.x, -n_o * wo.x, 1e-14);
        EXPECT_NEAR(s.weight.x, (n_o / n_i) * (n_o / n_i), 1e-15);
        EXPECT_NEAR(s.eta, n_i / n_o, 1e-15);
        EXPECT_NEAR(s.pdf, 1.0 - reflectance, 1e-15);
      }
    }
    EXPECT_NEAR(reflected, n * reflectance, 1.0);
  }
  EXPECT_EQ(sample(glass, {1, 0, 0}, 0.5, {0, 0}).lobe, Lobe::none);
}

ReconstructionFilter make_filter(ReconstructionFilter::Type type, double radius, double stddev, double b, double c) {
  return {.type = type, .radius = radius, .stddev = stddev, .b = b, .c = c};
}

std::vector<ReconstructionFilter> filters() {
  using Type = ReconstructionFilter::Type;
  return {make_filter(Type::tent, 2, 0.5, 0, 0),
          make_filter(Type::gaussian, 2, 0.5, 0, 0),
          make_filter(Type::gaussian, 2, 1e6, 0, 0),
          make_filter(Type::gaussian, 2, 0.01, 0, 0),
          make_filter(Type::mitchell, 2, 0, 1. / 3, 1. / 3),
          make_filter(Type::mitchell, 3, 0, 0, 1),
          make_filter(Type::mitchell, 1, 0, 1, 0),
          {.type = Type::box, .stretch = 3.0},
          {.type = Type::tent, .stretch = 0.7},
          {.type = Type::lanczos},
          {.type = Type::lanczos, .lobes = 4}};
}

TEST(ReferenceFilter, KnotsAreTheInverseCdf) {
  for (const ReconstructionFilter& filter : filters()) {
    const FilterSampler sampler(filter);
    const auto& knots = sampler.knots();
    ASSERT_EQ(knots.size(), 1025u);
    const double r = filter_radius(filter);
    EXPECT_EQ(knots.front(), -r);
    EXPECT_EQ(knots.back(), r);
    EXPECT_EQ(knots[512], 0.0);
    // Midpoint rule on a fine grid, independent of the construction.
    constexpr int n = 1 << 21;
    double all = 0.0, with_sign = 0.0;
    for (int i = 0; i < n; ++i) {
      const double f = filter_value(filter, -r + 2 * r * (i + 0.5) / n);
      all += std::abs(f), with_sign += f;
    }
    EXPECT_NEAR(sampler.normalization(), all / with_sign, 1e-7);
    double below = 0.0;
    int next = 1;
    for (int i = 0; i < n && next < 1024; ++i) {
      const double lo = -r + 2 * r * i / n, width = 2 * r / n;
      const double f = std::abs(filter_value(filter, lo + 0.5 * width));
      for (; next < 1024 && knots[next] <= lo + width; ++next) {
        EXPECT_LE(knots[next - 1], knots[next]);
        EXPECT_NEAR((below + f * (knots[next] - lo) / width) / all, next / 1024.0, 2e-8) << "knot " << next;
      }
      below += f;
    }
    EXPECT_EQ(next, 1024);
  }
}

TEST(ReferenceFilter, WeightedSamplesHaveTheFiltersMoments) {
  for (const ReconstructionFilter& filter : filters()) {
    const FilterSampler sampler(filter);
    const double r = filter_radius(filter);
    double mass = 0.0, second = 0.0;
    constexpr int n = 1 << 20;
    for (int i = 0; i < n; ++i) {
      const double x = -r + 2 * r * (i + 0.5) / n;
      mass += filter_value(filter, x), second += filter_value(filter, x) * x * x;
    }
    double weight = 0.0, moment = 0.0;
    for (int i = 0; i < n; ++i) {
      const auto s = sampler.sample((i + 0.5) / n);
      weight += s.weight / n, moment += s.weight * s.offset * s.offset / n;
    }
    // Between knots the density is constant, which costs a little.
    EXPECT_NEAR(weight, 1.0, 2e-3);
    EXPECT_NEAR(moment, second / mass, 2e-3 * r * r);
  }
}

TEST(ReferenceFilter, MitchellIsTheCubicOfThePaper) {
  const auto filter = make_filter(ReconstructionFilter::Type::mitchell, 2, 0, 1. / 3, 1. / 3);
  EXPECT_NEAR(filter_value(filter, 0.0), (6 - 2. / 3) / 6, 1e-15);
  EXPECT_NEAR(filter_value(filter, 1.0), (1. / 3) / 6, 1e-15);
  EXPECT_NEAR(filter_value(filter, 2.0), 0.0, 1e-15);
  EXPECT_LT(filter_value(filter, 1.5), 0.0);
  double sum = 0.0;  // a partition of unity
  for (int i = -3; i <= 3; ++i) sum += filter_value(filter, 0.37 + i);
  EXPECT_NEAR(sum, 1.0, 1e-14);
}

// Values that Mitsuba 3.9.1's own filter gives.
TEST(ReferenceFilter, LanczosIsASincThatEnds) {
  const ReconstructionFilter three{.type = ReconstructionFilter::Type::lanczos}, two{.type = three.type, .lobes = 2};
  for (const auto& [x, value] : {std::pair(0.0, 1.0),
                                 {0.25, 0.890067},
                                 {0.5, 0.607927},
                                 {1.2, -0.118001},
                                 {2.2, 0.027433},
                                 {2.9, 0.001167},
                                 {3.1, 0.0}})
    EXPECT_NEAR(filter_value(three, x), value, 1e-6) << x;
  EXPECT_NEAR(filter_value(two, -1.2), -0.078667, 1e-6);
  for (const double zero : {1.0, 2.0, 3.0}) EXPECT_NEAR(filter_value(three, zero), 0.0, 1e-16);
}

TEST(ReferenceChoice, ThresholdsAreExact) {
  const DiscreteChoice choice({1.0, 0.0, 1.0, 2.0, 0.0});
  const std::vector<std::uint64_t> expected{0, 1u << 30, 1u << 30, 1u << 31, 1ull << 32, 1ull << 32};
  EXPECT_EQ(choice.thresholds(), expected);
  EXPECT_EQ(choice.choose(0), 0u);
  EXPECT_EQ(choice.choose((1u << 30) - 1), 0u);
  EXPECT_EQ(choice.choose(1u << 30), 2u);
  EXPECT_EQ(choice.choose((1u << 31) - 1), 2u);
  EXPECT_EQ(choice.choose(1u << 31), 3u);
  EXPECT_EQ(choice.choose(0xffffffffu), 3u);
  EXPECT_EQ(choice.prob(3), 0.5);
  EXPECT_EQ(choice.prob(1), 0.0);
}

TEST(ReferenceChoice, TinyWeightsKeepAChance) {
  std::vector<double> weights(1000, 1e-30);
  weights[500] = 1.0;
  weights.push_back(1e-30);
  const DiscreteChoice choice(weights);
  double sum = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    EXPECT_GE(choice.prob(i), 0x1p-32) << i;
    EXPECT_EQ(choice.choose(static_cast<std::uint32_t>(choice.thresholds()[i])), i);
    sum += choice.prob(i);
  }
  EXPECT_EQ(sum, 1.0);
}

TEST(ReferenceChoice, NothingToChooseFrom) {
  EXPECT_TRUE(DiscreteChoice(std::vector<double>{}).empty());
  EXPECT_TRUE(DiscreteChoice(std::vector<double>{0.0, 0.0}).empty());
}

TEST(ReferenceCamera, RaysFollowTheConventions) {
  Camera camera;
  camera.width = 400, camera.height = 200, camera.fov = 90;
  camera.near_clip = 2, camera.far_clip = 8;
  EXPECT_LT(glm::length(camera_ray(camera, {200, 100}).direction - Vec3(0, 0, 1)), 1e-15);
  // Top left: +X is left, +Y is up, square pixels.
  const Ray corner = camera_ray(camera, {0, 0});
  EXPECT_LT(glm::length(corner.direction - glm::normalize(Vec3(1, 0.5, 1))), 1e-15);
  EXPECT_NEAR(corner.t_min, 2 * 1.5, 1e-14);
  EXPECT_NEAR(corner.t_max, 8 * 1.5, 1e-14);
  // A scaled matrix scales the clipping planes, a mirrored one the image.
  camera.world_from_camera = glm::dmat4(glm::dmat3(-3, 0, 0, 0, 3, 0, 0, 0, 3));
  const Ray mirrored = camera_ray(camera, {0, 0});
  EXPECT_LT(glm::length(mirrored.direction - glm::normalize(Vec3(-1, 0.5, 1))), 1e-15);
  EXPECT_NEAR(mirrored.t_min, 6 * 1.5, 1e-14);
  // Tiny fields of view keep their digits.
  camera.world_from_camera = glm::dmat4(1.0);
  camera.fov = 1e-6;
  EXPECT_NEAR(camera_ray(camera, {0, 100}).direction.x / glm::radians(0.5e-6), 1.0, 1e-12);
}

}  // namespace
}  // namespace etendue::reference::test
