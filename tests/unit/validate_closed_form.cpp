/// The closed forms against plain numerical integration, and the generated scenes against the reference.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "reference/reference_renderer.h"
#include "validate/closed_form.h"
#include "validate/statistics.h"

namespace etendue {
namespace {

using glm::dvec3;
constexpr double kPi = std::numbers::pi;

/// ∫ over the hemisphere of `n` of value(ω) · ω·n, by a fine grid that is even in (cos²θ, φ).
template <typename F>
double irradiance(const dvec3& n, const F& value) {
  constexpr int kRings = 1500, kSectors = 1500;
  const dvec3 s = glm::normalize(glm::cross(std::abs(n.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0), n)),
              t = glm::cross(n, s);
  double sum = 0.0;
  for (int i = 0; i < kRings; ++i) {
    const double sin2 = (i + 0.5) / kRings, sine = std::sqrt(sin2), cosine = std::sqrt(1.0 - sin2);
    for (int j = 0; j < kSectors; ++j) {
      const double phi = 2.0 * kPi * (j + 0.5) / kSectors;
      sum += value(sine * (std::cos(phi) * s + std::sin(phi) * t) + cosine * n);
    }
  }
  return kPi * sum / (double{kRings} * kSectors);
}

bool inside_polygon(const std::vector<dvec3>& polygon, const dvec3& d) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if (glm::dot(glm::cross(polygon[i], polygon[(i + 1) % polygon.size()]), d) > 0.0) return false;
  }
  return true;
}

TEST(ClosedForm, PolygonAboveAcrossAndBelowTheHorizon) {
  const std::vector<dvec3> above{{-0.5, 1.0, -0.5}, {0.6, 1.2, -0.4}, {0.3, 0.9, 0.7}};
  for (const dvec3& n :
       {dvec3(0, 1, 0), glm::normalize(dvec3(1, 0.2, 0)), glm::normalize(dvec3(-1, -0.3, 0.2)), dvec3(0, -1, 0)}) {
    const double grid = irradiance(n, [&](const dvec3& d) { return inside_polygon(above, d) ? 1.0 : 0.0; });
    EXPECT_NEAR(closed_form::polygon_irradiance(above, n), grid, 2e-3) << n.x << ' ' << n.y;
  }
  const std::vector<dvec3> turned(above.rbegin(), above.rend());
  EXPECT_EQ(closed_form::polygon_irradiance(turned, {0, 1, 0}), 0.0);
}

TEST(ClosedForm, PolygonIsThatOfTheCourseReferences) {
  const std::vector<dvec3> triangle{
      {-0.443432, 0.596366, 0.495985}, {-0.320397, 0.0677699, -0.229359}, {0.0341197, 0.11415, -0.343049}};
  EXPECT_NEAR(0.5 / kPi * closed_form::polygon_irradiance(triangle, {0, 1, 0}), 0.0898394, 5e-7);
}

TEST(ClosedForm, SphereAboveAcrossAndBelowTheHorizon) {
  for (const double elevation : {1.5, 0.9, 0.4, 0.2, 0.0, -0.2, -0.4, -0.9}) {
    const dvec3 axis(std::cos(elevation), std::sin(elevation), 0.0);
    const double radius = 0.6, distance = 1.3, least = std::cos(std::asin(radius / distance));
    const double grid = irradiance({0, 1, 0}, [&](const dvec3& d) { return glm::dot(d, axis) > least ? 1.0 : 0.0; });
    EXPECT_NEAR(closed_form::sphere_irradiance(distance * axis, radius, {0, 1, 0}), grid, 2e-3) << elevation;
  }
}

TEST(ClosedForm, TwoClampedCosines) {
  const dvec3 a = glm::normalize(dvec3(0.3, 0.5, -0.2));
  for (const dvec3& b : {a, -a, glm::normalize(dvec3(-0.5, 0.2, 0.1)), glm::normalize(dvec3(1, 1, 1))}) {
    const double grid = irradiance(a, [&](const dvec3& d) { return std::max(0.0, glm::dot(d, b)); });
    EXPECT_NEAR(closed_form::clamped_cosine_product(a, b), grid, 1e-4);
  }
}

TEST(ClosedForm, FresnelAtKnownAngles) {
  EXPECT_NEAR(closed_form::fresnel_reflectance(1.0, 1.0, 1.5), 0.04, 1e-15);
  EXPECT_NEAR(closed_form::fresnel_reflectance(1.0, 1.5, 1.0), 0.04, 1e-15);
  EXPECT_EQ(closed_form::fresnel_reflectance(0.5, 1.5, 1.0), 1.0);
  // Brewster's angle: only the perpendicular half is reflected.
  const double brewster = std::atan(1.5), s = std::cos(2.0 * brewster);
  EXPECT_NEAR(closed_form::fresnel_reflectance(std::cos(brewster), 1.0, 1.5), 0.5 * s * s, 1e-12);
}

TEST(ClosedForm, FilterSharesAreSymmetricAndWhole) {
  for (int type = 0; type < 5; ++type) {
    ReconstructionFilter f;
    f.type = static_cast<ReconstructionFilter::Type>(type);
    EXPECT_NEAR(closed_form::filter_share(f, 0.0), 0.5, 1e-6);
    EXPECT_NEAR(closed_form::filter_share(f, 10.0), 1.0, 1e-12);
    EXPECT_NEAR(closed_form::filter_share(f, 0.3) + closed_form::filter_share(f, -0.3), 1.0, 1e-6);
  }
  ReconstructionFilter tent;
  tent.type = ReconstructionFilter::Type::tent;
  EXPECT_NEAR(closed_form::filter_share(tent, 0.5), 0.875, 1e-6);
}

TEST(ClosedForm, ScenesAreAPureFunctionOfTheSeed) {
  for (const SceneFamily family : kSceneFamilies) {
    const ClosedFormScene a = make_closed_form(family, 7), b = make_closed_form(family, 7),
                          c = make_closed_form(family, 8);
    EXPECT_EQ(a.expected, b.expected);
    EXPECT_EQ(scene_hash(a.scene), scene_hash(b.scene));
    EXPECT_NE(a.expected, c.expected);
    EXPECT_GT(a.expected, 0.0);
  }
}

/// Fixed seeds: in 70 tests a correct renderer stays below |t| = 5 with probability 0.99996.
TEST(ClosedForm, TheReferenceAgrees) {
  for (const SceneFamily family : kSceneFamilies) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const ClosedFormScene c = make_closed_form(family, seed);
      Film film(1, 1, film_exponent(c.scene));
      std::vector<RejectedSample> rejected;
      make_reference_renderer(c.scene, {static_cast<std::uint32_t>(seed), FilmQuantity::luminance})
          ->render({0, 20000}, film, {}, rejected);
      const Moments m = film_moments(film, 0);
      const TTestResult t = t_test(static_cast<double>(m.mean), static_cast<double>(m.variance), m.n, c.expected);
      EXPECT_GT(t.p_value, 5.7e-7) << c.scene.name << ", " << c.name << ": " << t.mean << " ± " << t.standard_error
                                   << ", expected " << c.expected;
      EXPECT_EQ(film.rejected(), 0u);
    }
  }
}

}  // namespace
}  // namespace etendue
