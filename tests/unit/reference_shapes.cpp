// Disks and cylinders of the reference, against what defines them.

#include <random>

#include <gtest/gtest.h>
#include <glm/gtc/matrix_transform.hpp>

#include "reference/placement.h"
#include "reference/shapes.h"
#include "scene/invariants.h"
#include "scene/placed.h"

namespace etendue::reference {
namespace {

class Numbers {
 public:
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vector() { return {in(-1, 1), in(-1, 1), in(-1, 1)}; }

 private:
  std::mt19937 engine_{7};
};

TEST(ReferenceShapes, EllipsesAreImagesOfTheDisk) {
  Numbers numbers;
  int hits = 0;
  for (int i = 0; i < 20000; ++i) {
    Instance instance;
    for (int c = 0; c < 3; ++c) instance.world_from_object[c] = glm::dvec4(numbers.vector(), 0.0);
    instance.world_from_object[3] = glm::dvec4(numbers.vector(), 1.0);
    if (std::abs(glm::determinant(instance.world_from_object)) < 1e-3) continue;
    instance.flip_normals = i % 2 == 0;
    const Ellipse disk = Placement(instance).disk();
    // The ray seen from object space, where the disk is the unit disk.
    const Ray ray{.origin = 3.0 * numbers.vector(), .direction = glm::normalize(numbers.vector())};
    const glm::dmat4 object_from_world = glm::inverse(instance.world_from_object);
    const Vec3 o(object_from_world * glm::dvec4(ray.origin, 1.0)),
        d(object_from_world * glm::dvec4(ray.direction, 0.0));
    const double t = -o.z / d.z;
    const Vec3 p = o + t * d;
    const double r = std::hypot(p.x, p.y);
    const auto found = intersect(ray, disk, INFINITY);
    if (std::abs(r - 1.0) < 1e-6 || std::abs(t) < 1e-9) continue;
    ASSERT_EQ(found.has_value(), r < 1.0 && t > 0.0) << i;
    // The normal stays on its side: it leaves toward the image of +z, or is flipped.
    EXPECT_EQ(glm::dot(disk.normal(), Vec3(instance.world_from_object[2])) > 0.0, !instance.flip_normals);
    if (!found) continue;
    ++hits;
    EXPECT_NEAR(*found, t, 1e-9 * (1.0 + t));
    EXPECT_FALSE(intersect(ray, disk, *found).has_value());
  }
  EXPECT_GT(hits, 300);
}

TEST(ReferenceShapes, AreasOfEllipses) {
  Instance instance;
  instance.world_from_object =
      glm::dmat4(glm::dvec4(2, 0, 0, 0), glm::dvec4(5, 0, 3, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, 0, 1));
  EXPECT_NEAR(Placement(instance).disk().area(), 6.0 * kPi, 1e-12);
  EXPECT_NEAR(placed_disk(instance).area(), 6.0 * kPi, 1e-12);
  EXPECT_EQ(placed_disk(instance).reach(), glm::dvec3(std::sqrt(29.0), 0.0, 3.0));
}

TEST(ReferenceShapes, TubesAreMetWhereTheyAre) {
  Numbers numbers;
  int hits = 0, through_the_opening = 0;
  for (int i = 0; i < 1500; ++i) {
    const Tube tube{.base = numbers.vector(),
                    .axis = glm::normalize(numbers.vector()),
                    .height = numbers.in(0.1, 2.0),
                    .radius = numbers.in(0.05, 1.0)};
    const Vec3 origin = 2.0 * numbers.vector();
    const Vec3 aim = tube.base + 0.5 * tube.height * tube.axis + tube.radius * numbers.vector();
    const Ray ray{.origin = origin, .direction = glm::normalize(aim - origin)};
    // Positive outside: where it changes its sign the ray passes the infinite cylinder.
    const auto beyond = [&](double t) {
      const Vec3 v = ray.origin + t * ray.direction - tube.base;
      return glm::length(v - glm::dot(v, tube.axis) * tube.axis) - tube.radius;
    };
    const auto along = [&](double t) { return glm::dot(ray.origin + t * ray.direction - tube.base, tube.axis); };
    std::optional<double> expected;
    bool unsure = false;
    constexpr double kStep = 1e-3;
    for (double t = 0.0; t < 8.0 && !expected; t += kStep) {
      if ((beyond(t) > 0.0) == (beyond(t + kStep) > 0.0)) continue;
      double low = t, high = t + kStep;
      for (int k = 0; k < 60; ++k)
        ((beyond(low) > 0.0) == (beyond(0.5 * (low + high)) > 0.0) ? low : high) = 0.5 * (low + high);
      if (std::abs(along(low)) < 1e-9 || std::abs(along(low) - tube.height) < 1e-9) unsure = true;
      if (along(low) >= 0.0 && along(low) <= tube.height)
        expected = low;
      else
        ++through_the_opening;
    }
    const auto found = intersect(ray, tube, 8.0);
    if (unsure || (found && !expected && std::abs(beyond(*found + kStep)) < 1e-5))
      continue;  // a touch between two steps
    ASSERT_EQ(found.has_value(), expected.has_value()) << i;
    if (!found) continue;
    ++hits;
    EXPECT_NEAR(*found, *expected, 1e-9);
  }
  EXPECT_GT(hits, 500);
  EXPECT_GT(through_the_opening, 200);
}

TEST(ReferenceShapes, TubesSeenAlongTheirAxisAndFromWithin) {
  const Tube tube{.base = {0, 0, 0}, .axis = {0, 0, 1}, .height = 2.0, .radius = 1.0};
  EXPECT_FALSE(intersect(Ray{.origin = {0.5, 0, -1}, .direction = {0, 0, 1}}, tube, INFINITY));
  EXPECT_EQ(intersect(Ray{.origin = {0, 0, 1}, .direction = {1, 0, 0}}, tube, INFINITY), 1.0);
  EXPECT_EQ(intersect(Ray{.origin = {-3, 0, 1}, .direction = {1, 0, 0}}, tube, INFINITY), 2.0);
  // Over the near wall, onto the far one from within.
  const Vec3 d = glm::normalize(Vec3(4, 0, -1.5));
  const auto t = intersect(Ray{.origin = {-3, 0, 3}, .direction = d}, tube, INFINITY);
  ASSERT_TRUE(t);
  EXPECT_NEAR((Vec3(-3, 0, 3) + *t * d).x, 1.0, 1e-12);
}

TEST(ReferenceShapes, CylindersStayOnesUnderSimilarities) {
  Instance instance;
  instance.world_from_object = glm::rotate(glm::translate(glm::dmat4(1.0), {1.0, 2.0, 3.0}), 0.7, {1.0, 1.0, 0.0}) *
                               glm::scale(glm::dmat4(1.0), glm::dvec3(-2.0));
  const Cylinder cylinder{{0, 0, 0}, {0, 0, 3}, 0.5};
  const Tube tube = Placement(instance).cylinder(cylinder);
  EXPECT_NEAR(tube.radius, 1.0, 1e-12);
  EXPECT_NEAR(tube.height, 6.0, 1e-12);
  EXPECT_EQ(tube.side, 1.0) << "its normal points outward in the mirror, too";
  const PlacedCylinder placed = placed_cylinder(cylinder, instance);
  EXPECT_LT(glm::distance(placed.p1, tube.base + tube.height * tube.axis), 1e-12);
  EXPECT_NEAR(placed.area(), tube.area(), 1e-12);
}

std::string first_error(Shape shape, const glm::dmat4& m) {
  Scene scene;
  scene.add(std::move(shape)).world_from_object = m;
  scene.instances[0].name = "it";
  Diagnostics diagnostics;
  check_invariants(scene, diagnostics);
  return diagnostics.has_errors() ? diagnostics.list().front().message : "";
}

TEST(ReferenceShapes, WhatCannotBeCarriedIsAnError) {
  glm::dmat4 shear(1.0);
  shear[1][0] = 0.1;
  const glm::dmat4 uneven = glm::scale(glm::dmat4(1.0), {1.0, 2.0, 1.0});
  for (const glm::dmat4& m : {shear, uneven}) {
    EXPECT_EQ(first_error(Disk{}, m), "");
    EXPECT_EQ(first_error(Cylinder{}, m),
              "the transform of the cylinder \"it\" scales it unevenly or shears it; use rotation, translation and "
              "uniform scale, or a mesh");
  }
  EXPECT_EQ(first_error(Cylinder{}, glm::scale(glm::dmat4(1.0), glm::dvec3(-3.0))), "");
  EXPECT_EQ(first_error(Cylinder{{1, 2, 3}, {1, 2, 3}, 1.0}, glm::dmat4(1.0)),
            "the cylinder \"it\" has no height: p0 and p1 are both 1 2 3; move one of them");
  EXPECT_NE(first_error(Disk{}, glm::scale(glm::dmat4(1.0), glm::dvec3(2e9))), "");
  EXPECT_NE(first_error(Cylinder{{0, 0, 0}, {0, 0, 1}, -1.0}, glm::dmat4(1.0)), "");
}

}  // namespace
}  // namespace etendue::reference
