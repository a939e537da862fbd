/// Places in the picture, against the rays that the reference's cameras send through them.

#include <cmath>

#include <gtest/gtest.h>

#include "reference/camera.h"
#include "reference_scenes.h"
#include "scene/film_projection.h"

namespace etendue::reference::test {
namespace {

std::vector<Camera> cameras() {
  std::vector<Camera> all;
  using Type = Camera::Type;
  using Axis = Camera::FovAxis;
  for (const Type type : {Type::perspective, Type::thin_lens, Type::orthographic, Type::spherical}) {
    for (const Axis axis : {Axis::x, Axis::y, Axis::diagonal, Axis::smaller, Axis::larger}) {
      Camera camera;
      camera.type = type;
      camera.width = 90;
      camera.height = axis == Axis::larger ? 130 : 50;
      camera.fov = 55.0;
      camera.fov_axis = axis;
      camera.world_from_camera = look_at({3, -2, 5}, {0.5, 1, 0}, {0, 1, 0});
      if (axis == Axis::diagonal) camera.world_from_camera[0] *= -1.5;  // mirrored, and not square
      if (axis == Axis::smaller)
        camera.window = {.origin = {0.25, 0.125}, .size = {0.5, 0.75}, .principal_offset = {0.05, -0.1}};
      all.push_back(camera);
    }
  }
  return all;
}

TEST(FilmProjection, APointLiesWhereItsRayLeftTheFilm) {
  for (const Camera& camera : cameras()) {
    SCOPED_TRACE(testing::Message() << static_cast<int>(camera.type) << " " << static_cast<int>(camera.fov_axis));
    for (const Vec2 film : {Vec2(0.25, 0.5), Vec2(89.5, 3.25), Vec2(45.0, 25.0), Vec2(10.0, 49.0)}) {
      const Ray ray = camera_ray(camera, film, {});
      for (const double t : {0.1, 2.0, 700.0}) {
        const auto place = film_place(camera, ray.origin + t * ray.direction);
        ASSERT_TRUE(place.has_value());
        EXPECT_NEAR(place->x, film.x, 1e-6);
        EXPECT_NEAR(place->y, film.y, 1e-6);
      }
    }
  }
}

TEST(FilmProjection, WhatLiesBehindHasNoPlaceAndDirectionsHaveOne) {
  Camera camera;
  camera.width = camera.height = 100;
  camera.world_from_camera = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0});
  EXPECT_FALSE(film_place(camera, {0, 0, 6}).has_value());
  EXPECT_TRUE(film_place(camera, {0, 0, 4}).has_value());
  const auto projection = film_projection(camera);
  ASSERT_TRUE(projection.has_value());
  const glm::dvec4 ahead = projection->matrix * glm::dvec4(0, 0, -1, 0);
  EXPECT_NEAR(ahead.x / ahead.w, 50.0, 1e-9);
  EXPECT_NEAR(ahead.y / ahead.w, 50.0, 1e-9);
  EXPECT_LT((projection->matrix * glm::dvec4(0, 0, 1, 0)).w, 0.0);
  for (const Camera::Type type : {Camera::Type::radiance_meter, Camera::Type::irradiance_meter}) {
    camera.type = type;
    EXPECT_FALSE(film_projection(camera).has_value());
  }
}

}  // namespace
}  // namespace etendue::reference::test
