#include "scene/placed.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace etendue {

bool turns_winding(const Instance& instance) {
  return (glm::determinant(glm::dmat3(instance.world_from_object)) < 0.0) != instance.flip_normals;
}

PlacedMesh::PlacedMesh(const TriangleMesh& mesh, const Instance& instance)
    : mesh_(mesh),
      world_from_object_(instance.world_from_object),
      normal_matrix_(glm::transpose(glm::inverse(glm::dmat3(instance.world_from_object)))),
      turned_(turns_winding(instance)) {
  if (instance.flip_normals) normal_matrix_ = -normal_matrix_;
}

glm::dvec3 PlacedMesh::normal(std::uint32_t vertex) const {
  const glm::dvec3 n = normal_matrix_ * mesh_.normals[vertex];
  const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
  return glm::normalize(n / largest);  // scaled first: the matrix may hold whatever a double holds
}

Sphere placed_sphere(const Sphere& sphere, const Instance& instance) {
  return {glm::dvec3(instance.world_from_object * glm::dvec4(sphere.center, 1.0)),
          sphere.radius * glm::length(glm::dvec3(instance.world_from_object[0]))};
}

PlacedDisk placed_disk(const Instance& instance) {
  const glm::dmat4& m = instance.world_from_object;
  PlacedDisk disk{glm::dvec3(m[3]), glm::dvec3(m[0]), glm::dvec3(m[1])};
  if (turns_winding(instance)) std::swap(disk.a, disk.b);
  return disk;
}

glm::dvec3 PlacedDisk::normal() const {
  return glm::normalize(glm::cross(glm::normalize(a), glm::normalize(b)));
}

double PlacedDisk::area() const {
  return std::numbers::pi * glm::length(glm::cross(a, b));
}

glm::dvec3 PlacedDisk::reach() const {
  return glm::sqrt(a * a + b * b);
}

PlacedCylinder placed_cylinder(const Cylinder& cylinder, const Instance& instance) {
  const glm::dmat4& m = instance.world_from_object;
  return {glm::dvec3(m * glm::dvec4(cylinder.p0, 1.0)), glm::dvec3(m * glm::dvec4(cylinder.p1, 1.0)),
          cylinder.radius * glm::length(glm::dvec3(m[0])), instance.flip_normals};
}

double PlacedCylinder::area() const {
  return 2.0 * std::numbers::pi * radius * glm::distance(p0, p1);
}

glm::dvec3 PlacedCylinder::reach() const {
  const glm::dvec3 w = glm::normalize(p1 - p0);
  return radius * glm::sqrt(glm::max(glm::dvec3(0.0), 1.0 - w * w));
}

double triangle_area(const TriangleMesh& mesh, const glm::uvec3& t) {
  return triangle_area({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
}

double triangle_area(const std::array<glm::dvec3, 3>& p) {
  return 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
}

}  // namespace etendue
