/// Ray against one primitive, compared with double precision.

#include <algorithm>
#include <cmath>
#include <optional>

#include "device_test.h"
#include "reference/shapes.h"

namespace etendue::test {
namespace {

class DeviceIntersect : public DeviceTest {
 protected:
  std::vector<gpu::IntersectAnswer> intersect(const std::vector<gpu::IntersectCase>& cases) {
    return run<gpu::IntersectAnswer>({kernels::intersections, "intersections", nullptr, {}}, cases);
  }
};

gpu::IntersectCase triangle_case(const glm::vec3& o, const glm::vec3& d, const glm::vec3& a, const glm::vec3& b,
                                 const glm::vec3& c) {
  return {o, 0.0f, d, INFINITY, a, gpu::kPrimitiveTriangle, b, 0, c, 0};
}
gpu::IntersectCase sphere_case(const glm::vec3& o, const glm::vec3& d, const glm::vec3& center, float radius) {
  return {o, 0.0f, d, INFINITY, center, gpu::kPrimitiveSphere, {radius, 0, 0}, 0, {}, 0};
}
glm::vec3 unit(const glm::dvec3& v) {
  return glm::vec3(glm::normalize(v));
}

// [Moeller1997] in double precision.
struct Solution {
  double t, b1, b2, det;
};
Solution solve(const gpu::IntersectCase& c) {
  const glm::dvec3 d = c.d, e1 = glm::dvec3(c.p1) - glm::dvec3(c.p0), e2 = glm::dvec3(c.p2) - glm::dvec3(c.p0);
  const glm::dvec3 pvec = glm::cross(d, e2), tvec = glm::dvec3(c.o) - glm::dvec3(c.p0), qvec = glm::cross(tvec, e1);
  const double det = glm::dot(e1, pvec);
  return {glm::dot(e2, qvec) / det, glm::dot(tvec, pvec) / det, glm::dot(d, qvec) / det, det};
}

TEST_F(DeviceIntersect, RandomTrianglesAgreeWithDoublePrecision) {
  Random random(1);
  std::vector<gpu::IntersectCase> cases;
  for (int i = 0; i < 100000; ++i) {
    const float size = std::exp2(random.uniform(-12.0f, 0.0f));
    const glm::vec3 middle = random.point(0.5f), a = middle + random.point(size), b = middle + random.point(size),
                    c = middle + random.point(size);
    const glm::vec3 o = random.point(1.0f);
    const float u = random.uniform(-0.3f, 1.0f), v = random.uniform(-0.3f, 1.0f);
    cases.push_back(triangle_case(o, unit(glm::dvec3(a + u * (b - a) + v * (c - a) - o)), a, b, c));
  }
  const auto answers = intersect(cases);
  std::size_t judged = 0, hits = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto& c = cases[i];
    const Solution s = solve(c);
    const double extent = std::max(glm::length(glm::dvec3(c.p1 - c.p0)), glm::length(glm::dvec3(c.p2 - c.p0)));
    // What rounding of the coordinates about the origin of the ray can move a barycentric weight.
    const double slack = 2e-6 * extent / std::abs(s.det) * std::max(1.0, s.t * s.t);
    const double margin = std::min({s.b1, s.b2, 1.0 - s.b1 - s.b2});
    if (!(slack < 0.05) || std::abs(margin) < slack || std::abs(s.t) < 1e-4) continue;
    ++judged;
    const bool hit = margin > 0.0 && s.t > 0.0;
    ASSERT_EQ(answers[i].found, hit ? 1u : 0u) << i << " margin " << margin << " slack " << slack;
    if (!hit) continue;
    ++hits;
    EXPECT_NEAR(answers[i].b1, s.b1, slack);
    EXPECT_NEAR(answers[i].b2, s.b2, slack);
    EXPECT_NEAR(answers[i].t, s.t, slack * extent * 4 + 1e-6);
  }
  EXPECT_GT(judged, cases.size() * 8 / 10);
  EXPECT_GT(hits, cases.size() / 10);
}

TEST_F(DeviceIntersect, SharedEdgesAndVerticesHaveNoGaps) {
  // Fans around a vertex: a ray aimed at the shared vertex or at a point of a shared edge hits at least one of the two
  // triangles.
  Random random(2);
  std::vector<gpu::IntersectCase> cases;
  for (int i = 0; i < 50000; ++i) {
    const glm::vec3 a = random.point(0.5f), b = random.point(0.5f);
    const glm::vec3 left = random.point(0.5f),
                    right = a + b - left + 0.1f * random.point(1.0f);  // on either side of the edge a b
    const glm::vec3 target =
        i % 5 == 0 ? a : glm::vec3(glm::mix(glm::dvec3(a), glm::dvec3(b), static_cast<double>(random.unit())));
    const glm::vec3 o =
        target + 2.0f * unit(glm::cross(glm::dvec3(b - a), glm::dvec3(left - a)) + 0.05 * random.direction());
    cases.push_back(triangle_case(o, unit(glm::dvec3(target) - glm::dvec3(o)), a, b, left));
    cases.push_back(triangle_case(o, cases.back().d, b, a, right));
  }
  const auto answers = intersect(cases);
  std::size_t judged = 0, gaps = 0, through_both = 0;
  for (std::size_t i = 0; i < cases.size(); i += 2) {
    // Rounding may send the ray past the end of the edge, where neither triangle is: only interior points of the edge
    // are judged.
    const glm::dvec3 a = cases[i].p0, b = cases[i].p1, o = cases[i].o, d = cases[i].d;
    const glm::dvec3 target = o + d * glm::dot(a - o, d);
    if (glm::length(target - a) < 1e-4) continue;
    const double along = glm::dot((o + 2.0 * d) - a, b - a) / glm::dot(b - a, b - a);
    if (along < 0.01 || along > 0.99 || glm::length(b - a) < 0.01) continue;
    // As the ray sees them the two lie on different sides of the edge.
    const double left = glm::dot(glm::cross(b - a, glm::dvec3(cases[i].p2) - a), d),
                 right = glm::dot(glm::cross(b - a, glm::dvec3(cases[i + 1].p2) - a), d);
    if (left * right >= 0.0 || std::min(std::abs(left), std::abs(right)) < 1e-4) continue;
    ++judged;
    if (answers[i].found == 0 && answers[i + 1].found == 0) ++gaps;
    if (answers[i].found == 1 && answers[i + 1].found == 1) ++through_both;
  }
  EXPECT_EQ(gaps, 0u);
  EXPECT_GT(judged, cases.size() / 4);
  EXPECT_LT(through_both, judged / 5);  // the edge itself belongs to both, its sides to one
}

TEST_F(DeviceIntersect, DegenerateTrianglesAreNeverHit) {
  Random random(3);
  std::vector<gpu::IntersectCase> cases;
  for (int i = 0; i < 3000; ++i) {
    const glm::vec3 a = random.point(0.5f), b = random.point(0.5f), o = random.point(1.0f);
    const glm::vec3 d = unit(glm::dvec3(glm::mix(a, b, random.unit()) - o));
    cases.push_back(triangle_case(o, d, a, a, a));
    cases.push_back(triangle_case(o, unit(glm::dvec3(a - o)), a, a, a));
    cases.push_back(triangle_case(o, d, a, b, a));
    cases.push_back(triangle_case(o, d, a, b, b));
    cases.push_back(triangle_case(o, d, a, a, b));
  }
  for (const auto& a : intersect(cases)) EXPECT_EQ(a.found, 0u);
}

TEST_F(DeviceIntersect, TheIntervalOfTheRayIsOpen) {
  std::vector<gpu::IntersectCase> cases;
  const auto add = [&](float t_min, float t_max) {
    gpu::IntersectCase c = triangle_case({0.25f, 0.25f, -1.0f}, {0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    c.t_min = t_min;
    c.t_max = t_max;
    cases.push_back(c);
    c = sphere_case({0, 0, -2}, {0, 0, 1}, {0, 0, 0}, 1.0f);
    c.t_min = t_min;
    c.t_max = t_max;
    cases.push_back(c);
  };
  add(0.0f, INFINITY), add(0.5f, 1.5f), add(1.0f, 5.0f), add(0.0f, 1.0f), add(3.0f, 9.0f), add(0.999999f, 1.000001f);
  const auto a = intersect(cases);
  const std::vector<gpu::uint> triangle_found = {1, 1, 0, 0, 0, 1};
  for (std::size_t i = 0; i < triangle_found.size(); ++i) EXPECT_EQ(a[2 * i].found, triangle_found[i]) << i;
  EXPECT_EQ(a[1].t, 1.0f);
  EXPECT_EQ(a[3].t, 1.0f);
  EXPECT_EQ(a[5].found, 1u);  // the near point is not beyond t_min = 1, the far one at 3 is
  EXPECT_EQ(a[5].t, 3.0f);
  EXPECT_EQ(a[7].found, 0u);  // t_max = 1 excludes the near point
  EXPECT_EQ(a[9].found, 0u);
  EXPECT_EQ(a[11].found, 1u);
}

// Distances to both intersections in double precision, with the discriminant relative to radius².
struct SphereSolution {
  double near, far, discriminant;
};
SphereSolution solve_sphere(const gpu::IntersectCase& c) {
  const glm::dvec3 f = glm::dvec3(c.p0) - glm::dvec3(c.o), d = c.d;
  const double dd = glm::dot(d, d), b = glm::dot(f, d) / dd;
  const glm::dvec3 l = f - b * d;
  const double r2 = static_cast<double>(c.p1.x) * c.p1.x, disc = r2 - glm::dot(l, l);
  const double root = std::sqrt(std::max(0.0, disc) / dd);
  return {b - root, b + root, disc / r2};
}

TEST_F(DeviceIntersect, SpheresFromOutsideInsideAndFar) {
  Random random(4);
  std::vector<gpu::IntersectCase> cases;
  for (int i = 0; i < 100000; ++i) {
    const float radius = std::exp2(random.uniform(-8.0f, 0.0f));
    const glm::vec3 center = random.point(0.5f);
    const double distance =
        radius * std::exp2(static_cast<double>(random.uniform(-3.0f, 6.0f)));  // from inside to 64 radii away
    const glm::vec3 o(glm::dvec3(center) + distance * random.direction());
    const glm::dvec3 aim = glm::dvec3(center) + 1.2 * radius * static_cast<double>(random.unit()) * random.direction();
    cases.push_back(sphere_case(o, unit(aim - glm::dvec3(o)), center, radius));
  }
  const auto answers = intersect(cases);
  std::size_t judged = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const SphereSolution s = solve_sphere(cases[i]);
    const double radius = cases[i].p1.x, far = std::max(1.0, s.far / radius);
    // Rounding of o − centre against the radius; near the rim its root counts.
    const double noise = 1e-6 * far + 1e-6 / radius;
    if (std::abs(s.discriminant) < 10 * noise || std::abs(s.near) < noise * radius || std::abs(s.far) < noise * radius)
      continue;
    ++judged;
    const double t = s.near > 0.0 ? s.near : s.far;
    const bool hit = s.discriminant > 0.0 && t > 0.0;
    ASSERT_EQ(answers[i].found, hit ? 1u : 0u) << i << ' ' << s.discriminant << ' ' << radius;
    if (!hit) continue;
    EXPECT_NEAR(answers[i].t, t, radius * noise / std::sqrt(s.discriminant) + 1e-6 * t)
        << i << ' ' << radius << ' ' << s.discriminant;
  }
  EXPECT_GT(judged, cases.size() * 8 / 10);
}

TEST_F(DeviceIntersect, SpecialSpheres) {
  const std::vector<gpu::IntersectCase> cases = {
      sphere_case({0, 0, 0}, {0, 0, 1}, {0, 0, 0}, 2.0f),      // from the centre
      sphere_case({0, 0, 3}, {0, 0, 1}, {0, 0, 0}, 1.0f),      // behind
      sphere_case({2, 0, -3}, {0, 0, 1}, {0, 0, 0}, 1.0f),     // beside
      sphere_case({0.5f, 0, -3}, {0, 0, 1}, {0, 0, 0}, 0.25f)  // beside a smaller one
  };
  const auto a = intersect(cases);
  EXPECT_EQ(a[0].found, 1u);
  EXPECT_EQ(a[0].t, 2.0f);
  for (int i = 1; i < 4; ++i) EXPECT_EQ(a[i].found, 0u) << i;
}

TEST_F(DeviceIntersect, GroundSphereKeepsItsPrecision) {
  // A sphere of radius 1000 whose surface passes under a camera near the origin: the naive quadratic is off by 1e-3
  // there.
  Random random(5);
  std::vector<gpu::IntersectCase> cases;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 o(random.uniform(-1, 1), random.uniform(0.5f, 2.0f), random.uniform(-1, 1));
    glm::dvec3 d = random.direction();
    d.y = -std::abs(d.y) - 0.1;
    cases.push_back(sphere_case(o, unit(d), {0, -1000, 0}, 1000.0f));
  }
  const auto answers = intersect(cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    ASSERT_EQ(answers[i].found, 1u);
    EXPECT_NEAR(answers[i].t, solve_sphere(cases[i]).near, 2e-3);
  }
}

reference::Ray exact_ray(const gpu::IntersectCase& c) {
  return {.origin = glm::dvec3(c.o), .direction = glm::normalize(glm::dvec3(c.d))};
}

// From one to a thousand radii away, grazing ones included: judged where rounding cannot decide.
TEST_F(DeviceIntersect, DisksNearFarAndSlanted) {
  Random random(6);
  std::vector<gpu::IntersectCase> cases;
  for (int i = 0; i < 50000; ++i) {
    const double size = std::exp2(static_cast<double>(random.uniform(-8.0f, -1.0f)));
    const glm::dvec3 center(random.point(0.5f)), a = size * random.direction(), b = size * random.direction();
    const glm::dvec3 o =
        center + size * std::exp2(static_cast<double>(random.uniform(-1.0f, 9.0f))) * random.direction();
    const glm::dvec3 aim = center + static_cast<double>(random.uniform(-1.2f, 1.2f)) * a +
                           static_cast<double>(random.uniform(-1.2f, 1.2f)) * b;
    cases.push_back({glm::vec3(o), 0.0f, unit(aim - o), INFINITY, glm::vec3(center), gpu::kPrimitiveDisk,
                     glm::vec3(center + a), 0, glm::vec3(center + b), 0});
  }
  const auto answers = intersect(cases);
  std::size_t judged = 0, hits = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const gpu::IntersectCase& c = cases[i];
    const glm::dvec3 p0(c.p0);
    const reference::Ellipse disk{p0, glm::dvec3(c.p1) - p0, glm::dvec3(c.p2) - p0};
    const reference::Ray ray = exact_ray(c);
    const double cosine = glm::dot(disk.normal(), ray.direction);
    const double t = glm::dot(disk.normal(), p0 - ray.origin) / cosine;
    const glm::dvec2 xy = disk.coordinates(ray.origin + t * ray.direction);
    // What rounding of coordinates up to 1 does to a point of the plane, in units of the thinner half axis.
    const double thin = disk.area() / (reference::kPi * std::max(glm::length(disk.a), glm::length(disk.b)));
    const double noise = 2e-6 * std::max(1.0, std::abs(t)) / (thin * std::max(1e-9, std::abs(cosine)));
    const double r = glm::length(xy);
    if (noise > 0.2 || std::abs(r - 1.0) < noise || std::abs(t) < 1e-6 / std::abs(cosine)) continue;
    ++judged;
    const bool hit = r < 1.0 && t > 0.0;
    hits += hit;
    ASSERT_EQ(answers[i].found, hit ? 1u : 0u) << i << ' ' << r << ' ' << t << ' ' << noise;
    if (!hit) continue;
    EXPECT_NEAR(answers[i].t, t, 2e-6 * std::max(1.0, t) / std::abs(cosine)) << i;
  }
  EXPECT_GT(judged, cases.size() * 6 / 10);
  EXPECT_GT(hits, cases.size() / 10);
}

TEST_F(DeviceIntersect, CylindersFromOutsideInsideAndFar) {
  Random random(7);
  std::vector<gpu::IntersectCase> cases;
  for (int i = 0; i < 50000; ++i) {
    const double radius = std::exp2(static_cast<double>(random.uniform(-7.0f, -2.0f)));
    const glm::dvec3 base(random.point(0.5f));
    const glm::dvec3 axis = radius * static_cast<double>(random.uniform(0.5f, 6.0f)) * random.direction();
    const glm::dvec3 middle = base + static_cast<double>(random.unit()) * axis;
    const glm::dvec3 o =
        middle + radius * std::exp2(static_cast<double>(random.uniform(-3.0f, 6.0f))) * random.direction();
    const glm::dvec3 aim = middle + 1.2 * radius * static_cast<double>(random.unit()) * random.direction();
    cases.push_back({glm::vec3(o),
                     0.0f,
                     unit(aim - o),
                     INFINITY,
                     glm::vec3(base),
                     gpu::kPrimitiveCylinder,
                     glm::vec3(base + axis),
                     0,
                     {static_cast<float>(radius), 1.0f, 0.0f},
                     0});
  }
  const auto answers = intersect(cases);
  std::size_t judged = 0, hits = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const gpu::IntersectCase& c = cases[i];
    const glm::dvec3 base(c.p0), axis = glm::dvec3(c.p1) - base;
    const double height = glm::length(axis), radius = c.p2.x;
    const reference::Ray ray = exact_ray(c);
    const auto found = [&](double grown) {
      const glm::dvec3 w = axis / height;
      return reference::intersect(ray, {base - (grown - radius) * w, w, height + 2.0 * (grown - radius), grown},
                                  INFINITY);
    };
    // A little thinner and shorter, and a little thicker and longer: where these agree, rounding does not decide.
    const double far = std::max(1.0, glm::distance(ray.origin, base));
    const double noise = 2e-6 * far;
    const auto t = found(radius), less = found(radius - noise), more = found(radius + noise);
    const double slope = glm::length(glm::cross(axis / height, ray.direction));
    if (noise > 0.1 * radius || slope < 0.05 || t.has_value() != less.has_value() || t.has_value() != more.has_value())
      continue;
    if (t && (std::abs(*t - *less) > 0.05 * radius || std::abs(*t - *more) > 0.05 * radius)) continue;
    ++judged;
    hits += t.has_value();
    ASSERT_EQ(answers[i].found, t ? 1u : 0u) << i;
    if (!t) continue;
    EXPECT_NEAR(answers[i].t, *t, 4.0 * (std::abs(*t - *less) + std::abs(*t - *more)) + 1e-6 * far) << i;
  }
  EXPECT_GT(judged, cases.size() * 6 / 10);
  EXPECT_GT(hits, cases.size() / 4);
}

}  // namespace
}  // namespace etendue::test
