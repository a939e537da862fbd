#include "scene/placed.h"

#include <algorithm>
#include <cmath>

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

double triangle_area(const TriangleMesh& mesh, const glm::uvec3& t) {
  return triangle_area({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
}

double triangle_area(const std::array<glm::dvec3, 3>& p) {
  return 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
}

}  // namespace etendue
