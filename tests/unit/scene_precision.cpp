// Cameras whose pixels are smaller than what can be resolved are named, others are not.

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "scene/check.h"
#include "scene/precision.h"

namespace etendue {
namespace {

// A unit sphere at the origin in the middle of 1000 pixels that together are `width` wide there.
Scene seen_from(double distance, double width) {
  Scene scene;
  scene.add(Sphere{}, DiffuseBsdf{}, AreaEmitter{glm::dvec3(1.0)});
  scene.camera.width = scene.camera.height = 1000;
  scene.camera.fov = std::atan(0.5 * width / distance) * 360.0 / std::numbers::pi;
  scene.camera.far_clip = 4.0 * distance;
  scene.camera.world_from_camera[3] = glm::dvec4(0, 0, -distance, 1);
  return scene;
}

TEST(Precision, PixelsThatCanBeToldApart) {
  for (const double distance : {3.0, 1e3, 1e6})
    EXPECT_EQ(precision_complaint(seen_from(distance, 2.0)), "") << distance;
  EXPECT_EQ(precision_complaint(seen_from(1e6, 1e-2)), "");
  EXPECT_EQ(precision_complaint(Scene{}), "") << "nothing to be seen";
  Scene one_pixel = seen_from(3.0, 1e-9);
  one_pixel.camera.width = one_pixel.camera.height = 1;
  EXPECT_EQ(precision_complaint(one_pixel), "");
}

TEST(Precision, PixelsThatCannot) {
  const std::string devices = precision_complaint(seen_from(3.0, 1e-4));
  EXPECT_NE(devices.find("use --device reference"), std::string::npos) << devices;
  const std::string nobody = precision_complaint(seen_from(1e9, 1e-4));
  EXPECT_NE(nobody.find("not even double precision"), std::string::npos) << nobody;
  Diagnostics diagnostics;
  check_scene(seen_from(3.0, 1e-4), diagnostics);
  ASSERT_EQ(diagnostics.list().size(), 1u);
  EXPECT_EQ(diagnostics.list().front().message, devices);
}

}  // namespace
}  // namespace etendue
