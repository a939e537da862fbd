#pragma once
/// Scenes whose meshes are shared: the same with and without a tree of two levels.

#include <numbers>
#include <random>

#include <glm/gtc/matrix_transform.hpp>

#include "reference_scenes.h"
#include "scene/sharing.h"

namespace etendue::test {

/// A bumpy closed surface around the origin with vertex normals, 4 rows² − 4 rows triangles; `smooth` leaves them out.
inline TriangleMesh bumpy_ball(std::uint32_t rows, bool smooth = true) {
  const std::uint32_t columns = 2 * rows;
  TriangleMesh mesh;
  for (std::uint32_t row = 0; row <= rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const double theta = std::numbers::pi * row / rows, phi = 2.0 * std::numbers::pi * column / columns;
      const glm::dvec3 d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      const double radius = 0.7 + 0.1 * std::sin(5.0 * theta) * std::cos(3.0 * phi) * std::sin(theta);
      mesh.positions.push_back(radius * (row == 0 ? glm::dvec3(0, 1, 0) : row == rows ? glm::dvec3(0, -1, 0) : d));
      if (smooth) mesh.normals.push_back(row == 0 ? glm::dvec3(0, 1, 0) : row == rows ? glm::dvec3(0, -1, 0) : d);
    }
  }
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = row * columns + column, b = a + columns, next = (column + 1) % columns;
      const std::uint32_t c = (row + 1) * columns + next, d = row * columns + next;
      if (row + 1 < rows) mesh.triangles.emplace_back(a, c, b);
      if (row > 0) mesh.triangles.emplace_back(a, d, c);
    }
  }
  return mesh;
}

/// Rotation, uneven scale and shear; every third is mirrored.
inline glm::dmat4 random_transform(std::mt19937_64& engine, const glm::dvec3& at, double size) {
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  const glm::dvec3 axis = glm::normalize(glm::dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)) + 1e-3);
  glm::dmat4 m = glm::rotate(glm::translate(glm::dmat4(1.0), at), uniform(0, 6.28), axis);
  m = glm::scale(m, size * glm::dvec3(uniform(0.5, 1.5), uniform(0.5, 1.5), uniform(0.5, 1.5)));
  glm::dmat4 shear(1.0);
  shear[1][0] = uniform(-0.4, 0.4);
  shear[2][1] = uniform(-0.4, 0.4);
  if (engine() % 3 == 0) shear[0] *= -1.0;
  return m * shear;
}

/// A room with instances of two meshes, some of them lamps, some glass or mirrors, and a light sphere. `instancing`
/// says how it is compiled.
inline Scene instanced_room(std::uint64_t seed, Instancing instancing, std::uint32_t lamps = 6) {
  using reference::test::add;
  using reference::test::diffuse;
  using reference::test::quad;
  std::mt19937_64 engine(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  Scene scene;
  scene.name = scene.file = "instanced room";
  scene.instancing = instancing;
  add(scene, reference::test::box({-4, 0, -4}, {4, 5, 4}, true), DiffuseBsdf{{0.7, 0.6, 0.5}});
  add(scene, Sphere{{2.5, 0.7, -1.0}, 0.7}, MirrorBsdf{});
  const std::uint32_t smooth = static_cast<std::uint32_t>(scene.shapes.size());
  scene.shapes.emplace_back(bumpy_ball(8));
  scene.shapes.emplace_back(bumpy_ball(6, false));
  const auto material = static_cast<std::uint32_t>(scene.materials.size());
  scene.materials.push_back({.bsdf = DiffuseBsdf{{0.3, 0.6, 0.8}}});
  scene.materials.push_back({.bsdf = DiffuseBsdf{{0.8, 0.7, 0.2}}});
  scene.materials.push_back({.bsdf = DielectricBsdf{}});
  scene.emitters.push_back({.radiance = {4.0, 3.0, 2.0}});
  scene.emitters.push_back({.radiance = {1.0, 2.0, 5.0}});
  for (std::uint32_t i = 0; i < 18; ++i) {
    const glm::dvec3 at(uniform(-3, 3), uniform(0.6, 4.2), uniform(-3, 2));
    Instance instance{.shape = smooth + i % 2, .material = material + (i % 7 == 3 ? 2 : i % 2)};
    instance.world_from_object = random_transform(engine, at, uniform(0.25, 0.6));
    instance.flip_normals = i % 5 == 4 && i % 7 != 3;
    if (i < lamps) instance.emitter = i % 2, instance.material = material, instance.flip_normals = false;
    scene.instances.push_back(instance);
  }
  scene.integrator.max_depth = 6;
  scene.camera.width = 64;
  scene.camera.height = 48;
  scene.camera.fov = 70.0;
  scene.camera.world_from_camera = reference::test::look_at({0, 2.4, 3.9}, {0, 2.0, 0}, {0, 1, 0});
  return scene;
}

}  // namespace etendue::test
