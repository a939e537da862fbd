#include "reference/placement.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace etendue::reference {

Placement::Placement(const Instance& instance)
    : matrix_(instance.world_from_object), object_from_world_(glm::inverse(glm::dmat3(instance.world_from_object))) {
  // The cross product of two transformed edges is the cofactor matrix times the cross product of the edges.
  const Vec3 x(matrix_[0]), y(matrix_[1]), z(matrix_[2]);
  cofactors_ = glm::dmat3(glm::cross(y, z), glm::cross(z, x), glm::cross(x, y));
  const double determinant = glm::dot(x, cofactors_[0]);
  double largest = 0.0;
  for (int column = 0; column < 3; ++column) largest = std::max(largest, max_component(glm::abs(cofactors_[column])));
  cofactors_ /= largest;
  flipped_ = instance.flip_normals;
  side_ = (determinant < 0.0) != instance.flip_normals ? -1.0 : 1.0;
}

Vec3 Placement::normal(const Vec3& n) const {
  return glm::normalize(side_ * (cofactors_ * n));
}

Vec3 Placement::shading_normal(const TriangleMesh& mesh, std::uint32_t i, const Vec3& b, const Vec3& ng) const {
  if (mesh.normals.empty()) return ng;
  const glm::uvec3 t = ordered(mesh.triangles[i]);
  const Vec3 sum = b.x * normal(mesh.normals[t.x]) + b.y * normal(mesh.normals[t.y]) + b.z * normal(mesh.normals[t.z]);
  const double length = glm::length(sum);
  return length > 0.0 ? sum / length : ng;
}

glm::uvec3 Placement::ordered(const glm::uvec3& triangle) const {
  return side_ < 0.0 ? glm::uvec3(triangle.x, triangle.z, triangle.y) : triangle;
}

std::array<Vec3, 3> Placement::triangle(const TriangleMesh& mesh, std::uint32_t i) const {
  const glm::uvec3 t = ordered(mesh.triangles[i]);
  return {point(mesh.positions[t.x]), point(mesh.positions[t.y]), point(mesh.positions[t.z])};
}

Ray Placement::to_object(const Ray& ray) const {
  Ray local = ray;
  local.origin = object_from_world_ * (ray.origin - Vec3(matrix_[3]));
  local.direction = object_from_world_ * ray.direction;
  return local;
}

Ellipse Placement::disk() const {
  Ellipse ellipse{point(Vec3(0.0)), Vec3(matrix_[0]), Vec3(matrix_[1])};
  if (side_ < 0.0) std::swap(ellipse.a, ellipse.b);
  return ellipse;
}

Tube Placement::cylinder(const Cylinder& object) const {
  const Vec3 base = point(object.p0), axis = point(object.p1) - base;
  const double height = glm::length(axis);
  // Lengths scale alike in all directions: the radius as the height does.
  return {base, axis / height, height, object.radius * (height / glm::length(object.p1 - object.p0)),
          flipped_ ? -1.0 : 1.0};
}

Sphere Placement::sphere(const Sphere& object) const {
  // A similarity scales all lengths alike; the cube root of the volume ratio is the least one-sided way to say so.
  const double scale = std::cbrt(std::abs(glm::determinant(glm::dmat3(matrix_))));
  return {point(object.center), object.radius * scale};
}

}  // namespace etendue::reference
