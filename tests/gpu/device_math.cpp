/// Random words, warps, polynomials, frames and the Fresnel term, against double precision written from the formulas.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "compile/vertex_normals.h"
#include "device_test.h"
#include "reference/rng.h"

namespace etendue::test {
namespace {

constexpr double kPi = std::numbers::pi;

class DeviceMath : public DeviceTest {
 protected:
  std::vector<gpu::WarpAnswer> warp(gpu::uint which, const std::vector<glm::vec2>& us, float parameter = 0.0f) {
    std::vector<gpu::WarpCase> cases;
    cases.reserve(us.size());
    for (const glm::vec2& u : us) cases.push_back({u, parameter, which});
    return run<gpu::WarpAnswer>({kernels::warps, "warps", nullptr, {}}, cases);
  }
};

std::vector<glm::vec2> random_square(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<glm::vec2> us;
  for (std::size_t i = 0; i < n; ++i) {
    const float x = random.unit();
    us.emplace_back(x, random.unit());
  }
  return us;
}

// The corners, edges and centre of the half-open unit square, where maps go wrong.
std::vector<glm::vec2> special_square() {
  constexpr float kLast = 1.0f - 0x1p-24f;
  std::vector<glm::vec2> us;
  for (const float x : {0.0f, 0x1p-24f, 0.25f, 0.5f, 0.5f + 0x1p-24f, 0.75f, kLast}) {
    for (const float y : {0.0f, 0x1p-24f, 0.25f, 0.5f, 0.5f - 0x1p-24f, 0.75f, kLast}) us.emplace_back(x, y);
  }
  return us;
}

std::vector<glm::vec2> both_squares(std::size_t n, std::uint64_t seed) {
  std::vector<glm::vec2> us = special_square();
  const auto more = random_square(n, seed);
  us.insert(us.end(), more.begin(), more.end());
  return us;
}

// Cell of (a, b) in [0,1]² on a 16 × 16 grid.
std::size_t cell(double a, double b) {
  const auto index = [](double x) { return static_cast<std::size_t>(std::clamp(x * 16.0, 0.0, 15.0)); };
  return index(a) * 16 + index(b);
}
double turns(double y, double x) {
  return std::atan2(y, x) / (2.0 * kPi) + 0.5;
}

TEST_F(DeviceMath, RandomWordsAreThoseOfThePaper) {
  // Computed with big integers from the published listing.
  const std::vector<gpu::WordsCase> cases = {{0, 0, 0, 0}, {1, 2, 3, 4}, {~0u, ~0u, ~0u, ~0u}, {479999, 1023, 17, 7}};
  const std::vector<glm::uvec4> expected = {{0x0f02f829u, 0x2d568769u, 0x32b0c43bu, 0xd32548eau},
                                            {0x3622cd16u, 0xf11471d8u, 0xe1109b3fu, 0x02b94c2fu},
                                            {0x974ed892u, 0xc015dc67u, 0x9f955760u, 0xa1bba208u},
                                            {0xd94e04e6u, 0x998ab10au, 0xbb920c7au, 0x2c384679u}};
  const auto answers = run<gpu::WordsAnswer>({kernels::sampler_words, "sampler_words", nullptr, {}}, cases);
  for (std::size_t i = 0; i < cases.size(); ++i) EXPECT_EQ(answers[i].words, expected[i]) << i;
}

TEST_F(DeviceMath, SobolWordsAreThoseOfTheReference) {
  // L0: integers, equal to the bit for every size of a set, also beyond the first sets and with large indices.
  for (gpu::uint bits = 1; bits <= 12; ++bits) {
    std::vector<gpu::WordsCase> cases;
    for (gpu::uint i = 0; i < 4096; ++i) cases.push_back({i % 3, i, i % 9, 5});
    for (gpu::uint i = 0; i < 4096; ++i) cases.push_back({i * 977u, i * 1048573u + 11u, i % 64, i * i});
    const auto answers = run<gpu::WordsAnswer>(
        {kernels::sampler_words, "sampler_words", nullptr, {{gpu::kConstantSetBits, bits}}}, cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const gpu::WordsCase& c = cases[i];
      const auto expected = reference::SampleRandom(c.seed, c.pixel, c.sample_index, bits).block(c.block);
      ASSERT_EQ(answers[i].words, glm::uvec4(expected[0], expected[1], expected[2], expected[3]))
          << "2^" << bits << " points, case " << i;
    }
  }
}

TEST_F(DeviceMath, UnitFloatsAreTheTop24Bits) {
  std::vector<gpu::WordsCase> cases;
  for (gpu::uint i = 0; i < 20000; ++i) cases.push_back({i, 3 * i, i % 9, 5});
  for (const auto& a : run<gpu::WordsAnswer>({kernels::sampler_words, "sampler_words", nullptr, {}}, cases)) {
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(a.units[k], static_cast<float>(a.words[k] >> 8) / 16777216.0f);
      EXPECT_LT(a.units[k], 1.0f);
    }
  }
}

// Counts of 16 × 16 cells: one number of each case against the same number of the next.
std::array<double, 4> neighbour_uniformity(const std::vector<gpu::WordsAnswer>& answers) {
  std::array<double, 4> p{};
  for (int k = 0; k < 4; ++k) {
    std::vector<double> counts(256, 0.0);
    for (std::size_t i = 0; i + 1 < answers.size(); i += 2)
      ++counts[(answers[i].words[k] >> 28) * 16 + (answers[i + 1].words[k] >> 28)];
    p[k] = uniformity(counts);
  }
  return p;
}

TEST_F(DeviceMath, NeighbouringPixelsSamplesAndBlocksAreIndependent) {
  constexpr gpu::uint kCount = 1u << 16;
  const auto check = [&](const char* what, auto make) {
    std::vector<gpu::WordsCase> cases;
    for (gpu::uint i = 0; i < kCount; ++i) cases.push_back(make(i));
    const auto p =
        neighbour_uniformity(run<gpu::WordsAnswer>({kernels::sampler_words, "sampler_words", nullptr, {}}, cases));
    for (int k = 0; k < 4; ++k) EXPECT_GT(p[k], kSmallestP) << what << ", word " << k;
  };
  check("pixels", [](gpu::uint i) { return gpu::WordsCase{i, 0, 0, 0}; });
  check("samples", [](gpu::uint i) { return gpu::WordsCase{77, i, 1, 0}; });
  check("blocks", [](gpu::uint i) { return gpu::WordsCase{i / 16, 5, i % 16, 0}; });
  check("seeds", [](gpu::uint i) { return gpu::WordsCase{0, 0, 0, i}; });
}

TEST_F(DeviceMath, CosineAndSineOfAnOctant) {
  std::vector<glm::vec2> xs;
  constexpr int kSteps = 1 << 15;
  for (int i = -kSteps; i <= kSteps; ++i) xs.emplace_back(static_cast<float>(i * (0.25 * kPi / kSteps)), 0.0f);
  const auto answers = warp(gpu::kWarpOctant, xs);
  double worst = 0.0;
  for (std::size_t i = 0; i < xs.size(); ++i) {
    const double x = xs[i].x;
    worst = std::max({worst, std::abs(answers[i].value.x - std::cos(x)), std::abs(answers[i].value.y - std::sin(x))});
  }
  EXPECT_LT(worst, 1.2e-7);  // half a unit in the last place of 1 for the polynomial, as much for its rounding
}

TEST_F(DeviceMath, CosineAndSineOfATurn) {
  std::vector<glm::vec2> us = random_square(1 << 16, 1);
  for (int i = 0; i < 64; ++i) {
    for (const float step : {-0x1p-24f, 0.0f, 0x1p-24f})
      us.emplace_back(std::max(0.0f, static_cast<float>(i) / 64.0f + step), 0.0f);
  }
  const auto answers = warp(gpu::kWarpTurn, us);
  double worst = 0.0;
  for (std::size_t i = 0; i < us.size(); ++i) {
    const double x = 2.0 * kPi * us[i].x;
    worst = std::max({worst, std::abs(answers[i].value.x - std::cos(x)), std::abs(answers[i].value.y - std::sin(x))});
  }
  EXPECT_LT(worst, 2e-7);
}

TEST_F(DeviceMath, DiskIsTheConcentricMap) {
  const auto us = both_squares(20000, 2);
  const auto answers = warp(gpu::kWarpDisk, us);
  for (std::size_t i = 0; i < us.size(); ++i) {
    const double a = 2.0 * us[i].x - 1.0, b = 2.0 * us[i].y - 1.0;
    double r = 0.0, phi = 0.0;
    if (std::abs(a) > std::abs(b)) {
      r = a;
      phi = kPi / 4 * b / a;
    } else if (b != 0.0) {
      r = b;
      phi = kPi / 2 - kPi / 4 * a / b;
    }
    EXPECT_NEAR(answers[i].value.x, r * std::cos(phi), 4e-7) << a << ' ' << b;
    EXPECT_NEAR(answers[i].value.y, r * std::sin(phi), 4e-7) << a << ' ' << b;
  }
}

TEST_F(DeviceMath, DiskAndHemisphereAreUniform) {
  std::vector<double> disk(256, 0.0), hemisphere(256, 0.0);
  for (const auto& a : warp(gpu::kWarpDisk, random_square(1 << 17, 3))) {
    const double x = a.value.x, y = a.value.y;
    ASSERT_LE(x * x + y * y, 1.0 + 1e-6);
    ++disk[cell(x * x + y * y, turns(y, x))];
  }
  for (const auto& a : warp(gpu::kWarpCosineHemisphere, random_square(1 << 17, 4))) {
    const double z = a.value.z;
    ASSERT_NEAR(glm::length(glm::dvec3(a.value)), 1.0, 3e-7);
    ++hemisphere[cell(z * z, turns(a.value.y, a.value.x))];  // the CDF of cos θ under pdf cos θ/π is cos² θ
  }
  EXPECT_GT(uniformity(disk), kSmallestP);
  EXPECT_GT(uniformity(hemisphere), kSmallestP);
}

// A direction in the plane of the surface has density 0 and would end its path: one furnace sample in a million did.
TEST_F(DeviceMath, NoDirectionLiesInTheSurface) {
  for (const auto& a : warp(gpu::kWarpCosineHemisphere, both_squares(1 << 12, 4))) ASSERT_GE(a.value.z, 0x1p-12f);
}

TEST_F(DeviceMath, TriangleIsUniform) {
  const auto us = both_squares(1 << 17, 5);
  const auto answers = warp(gpu::kWarpTriangle, us);
  std::vector<double> counts(64, 0.0);  // the 64 congruent triangles of a mesh of 8 rows
  for (std::size_t i = 0; i < us.size(); ++i) {
    const glm::dvec3 b = answers[i].value;
    const double root = std::sqrt(static_cast<double>(us[i].x));
    EXPECT_NEAR(b.x, 1.0 - root, 2e-7);
    EXPECT_NEAR(b.y, us[i].y * root, 2e-7);
    EXPECT_NEAR(b.x + b.y + b.z, 1.0, 2e-7);
    EXPECT_GE(std::min({b.x, b.y, b.z}), -1e-7);
    if (i < special_square().size()) continue;
    const auto row = static_cast<std::size_t>(std::clamp(8.0 * (1.0 - b.x), 0.0, 7.0));  // from the vertex p0
    const double along = 8.0 * b.y, across = 8.0 * b.z;
    const bool down = std::floor(along) + std::floor(across) + 1.0 <= static_cast<double>(row);
    const auto column = std::min(static_cast<std::size_t>(std::max(0.0, along)), row);
    ++counts[row * row + (down && column < row ? row + 1 + column : column)];
  }
  EXPECT_GT(uniformity(counts), kSmallestP);
}

TEST_F(DeviceMath, ConeIsUniformFromWideToNarrow) {
  for (const float one_minus_cos_max : {1.0f, 0.3f, 1e-3f, 1e-7f, 1e-12f}) {
    std::vector<double> counts(256, 0.0);
    for (const auto& a : warp(gpu::kWarpCone, random_square(1 << 16, 6), one_minus_cos_max)) {
      const double x = a.value.x, y = a.value.y;
      const double sin2 = x * x + y * y;
      const double one_minus_cos = a.value.z > 0.5 ? sin2 / (1.0 + std::sqrt(1.0 - sin2)) : 1.0 - a.value.z;
      ASSERT_LE(one_minus_cos, one_minus_cos_max * (1.0 + 1e-6));
      ASSERT_NEAR(glm::length(glm::dvec3(a.value)), 1.0, 3e-7);
      ++counts[cell(one_minus_cos / one_minus_cos_max, turns(y, x))];
    }
    EXPECT_GT(uniformity(counts), kSmallestP) << one_minus_cos_max;
  }
}

TEST_F(DeviceMath, FramesAreOrthonormalAndRightHanded) {
  Random random(7);
  std::vector<gpu::FrameCase> cases;
  const auto add = [&](const glm::dvec3& n) { cases.push_back({glm::vec3(n), 0, glm::vec3(random.direction()), 0}); };
  for (const double z : {1.0, -1.0}) {
    add({0, 0, z});
    for (const double e : {1e-3, 1e-5, 1e-7, 1e-10}) add(glm::normalize(glm::dvec3(e, -2 * e, z)));
  }
  add({1, 0, 0}), add({0, -1, 0}), add(glm::normalize(glm::dvec3(1, 1, -0.0))),
      add(glm::normalize(glm::dvec3(1, 1, -1e-8)));
  for (int i = 0; i < 20000; ++i) add(random.direction());
  const auto answers = run<gpu::FrameAnswer>({kernels::frames, "frames", nullptr, {}}, cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const glm::dvec3 s = answers[i].s, t = answers[i].t, n = cases[i].n, w = cases[i].w;
    EXPECT_NEAR(glm::dot(s, s), 1.0, 1e-6);
    EXPECT_NEAR(glm::dot(t, t), 1.0, 1e-6);
    EXPECT_LT(std::max({std::abs(glm::dot(s, t)), std::abs(glm::dot(s, n)), std::abs(glm::dot(t, n))}), 1e-6);
    EXPECT_LT(glm::length(glm::cross(s, t) - n), 1e-6);
    EXPECT_LT(glm::length(glm::dvec3(answers[i].local) - glm::dvec3(glm::dot(w, s), glm::dot(w, t), glm::dot(w, n))),
              5e-7);
    EXPECT_LT(glm::length(glm::dvec3(answers[i].world) - w), 2e-6);
  }
}

TEST_F(DeviceMath, PackedNormalsComeBack) {
  std::vector<std::array<glm::dvec3, 3>> normals;
  // Small whole numbers, so that sums of their sizes are at most 9: these are exact but for the division.
  for (int x = -3; x <= 3; ++x)
    for (int y = -3; y <= 3; ++y)
      for (int z = -3; z <= 3; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const glm::dvec3 n = glm::normalize(glm::dvec3(x, y, z));
        normals.push_back({n, -n, {n.y, n.z, n.x}});
      }
  const std::size_t exact = normals.size();
  Random random(11);
  for (int i = 0; i < 100000; ++i) normals.push_back({random.direction(), random.direction(), random.direction()});
  std::vector<gpu::uvec4> packed;
  for (const auto& n : normals) packed.push_back(pack_normals(n[0], n[1], n[2]));
  const auto answers = run<gpu::NormalsAnswer>({kernels::vertex_normals, "vertex_normals", nullptr, {}}, packed);
  double worst = 0.0, worst_exact = 0.0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const std::array<gpu::vec4, 3> unfolded{answers[i].n0, answers[i].n1, answers[i].n2};
    double& most = i < exact ? worst_exact : worst;
    for (int k = 0; k < 3; ++k) most = std::max(most, glm::length(glm::dvec3(unfolded[k]) - normals[i][k]));
  }
  EXPECT_LT(worst, 2.2e-6);
  EXPECT_GT(worst, 1e-6);
  EXPECT_LT(worst_exact, 3e-7);
}

// The form with angles, which shares no intermediate with the form with cosines: r⊥ = −sin(θo − θt)/sin(θo + θt),
// r∥ = tan(θo − θt)/tan(θo + θt) [Born1999].
double fresnel_by_angles(double cos_o, double eta) {
  if (cos_o == 1.0) return std::pow((eta - 1.0) / (eta + 1.0), 2.0);
  if (cos_o == 0.0) return 1.0;
  const double sin_t = std::sqrt(1.0 - cos_o * cos_o) / eta;
  if (sin_t >= 1.0) return 1.0;
  const double o = std::acos(cos_o), t = std::asin(sin_t);
  return 0.5 * (std::pow(std::sin(o - t) / std::sin(o + t), 2.0) + std::pow(std::tan(o - t) / std::tan(o + t), 2.0));
}

TEST_F(DeviceMath, FresnelTermAgreesWithTheFormula) {
  std::vector<gpu::FresnelCase> cases;
  for (const float eta :
       {1.5046f / 1.000277f, 1.000277f / 1.5046f, 1.33f, 1.0f / 1.33f, 2.4f, 1.0f / 2.4f, 1.0f, 1.0001f, 10.0f}) {
    for (int i = 0; i <= 4000; ++i) cases.push_back({static_cast<float>(i) / 4000.0f, eta, 0, 0});
    for (const float c : {1e-7f, 1e-5f, 1e-3f, 1.0f - 0x1p-24f}) cases.push_back({c, eta, 0, 0});
  }
  const auto answers = run<gpu::FresnelAnswer>({kernels::fresnel_terms, "fresnel_terms", nullptr, {}}, cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const double cos_o = cases[i].cos_o, eta = cases[i].eta;
    const double sin2_t = (1.0 - cos_o * cos_o) / (eta * eta);
    ASSERT_TRUE(answers[i].reflectance >= 0.0f && answers[i].reflectance <= 1.000001f) << cos_o << ' ' << eta;
    if (std::abs(sin2_t - 1.0) < 1e-6) continue;  // at the critical angle rounding decides
    const double cos_t = std::sqrt(std::max(0.0, 1.0 - sin2_t));
    // F rises like the square root at the critical angle: rounding of sin² moves cos_t by 1/cos_t as much.
    const double tolerance = sin2_t < 1.0 ? 1e-6 + 1e-6 / cos_t : 0.0;
    EXPECT_NEAR(answers[i].cos_t, cos_t, sin2_t < 1.0 ? tolerance : 0.0) << cos_o << ' ' << eta;
    EXPECT_NEAR(answers[i].reflectance, eta == 1.0 && cos_o > 0.0 ? 0.0 : fresnel_by_angles(cos_o, eta), tolerance)
        << cos_o << ' ' << eta;
  }
}

TEST_F(DeviceMath, FresnelTermIsTheSameFromBothSides) {
  std::vector<gpu::FresnelCase> forward, backward;
  for (int i = 1; i <= 2000; ++i) forward.push_back({static_cast<float>(i) / 2000.0f, 1.5f, 0, 0});
  const auto there = run<gpu::FresnelAnswer>({kernels::fresnel_terms, "fresnel_terms", nullptr, {}}, forward);
  for (const auto& a : there) backward.push_back({a.cos_t, 1.0f / 1.5f, 0, 0});
  const auto back = run<gpu::FresnelAnswer>({kernels::fresnel_terms, "fresnel_terms", nullptr, {}}, backward);
  for (std::size_t i = 0; i < there.size(); ++i) {
    const double tolerance = 2e-6 / forward[i].cos_o;
    EXPECT_NEAR(back[i].reflectance, there[i].reflectance, tolerance) << forward[i].cos_o;
    EXPECT_NEAR(back[i].cos_t, forward[i].cos_o, tolerance);
  }
  // Brewster's angle, tan θ = n: the parallel part vanishes and half the perpendicular one is left.
  const double n = 1.5, expected = 0.5 * std::pow((n * n - 1.0) / (n * n + 1.0), 2.0);
  const std::vector<gpu::FresnelCase> brewster = {{static_cast<float>(1.0 / std::sqrt(1.0 + n * n)), 1.5f, 0, 0}};
  EXPECT_NEAR(run<gpu::FresnelAnswer>({kernels::fresnel_terms, "fresnel_terms", nullptr, {}}, brewster)[0].reflectance,
              expected, 1e-6);
}

}  // namespace
}  // namespace etendue::test
