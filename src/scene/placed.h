#pragma once
/// Shapes placed in the world by their instances. Points are transformed on demand, so that a large mesh is in memory
/// only once.

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace etendue {

/// True if the instance reverses its shape's winding, as a mirror or flip_normals does.
bool turns_winding(const Instance& instance);

/// A mesh in world space. The winding of its triangles agrees with their normals: if the instance reverses it, the
/// second and third vertex of each triangle are exchanged. Refers to the mesh.
class PlacedMesh {
 public:
  PlacedMesh(const TriangleMesh& mesh, const Instance& instance);

  const TriangleMesh& mesh() const { return mesh_; }
  std::size_t triangle_count() const { return mesh_.triangles.size(); }
  bool has_normals() const { return !mesh_.normals.empty(); }
  /// Indices of a triangle's vertices, in the order described above.
  glm::uvec3 indices(std::size_t triangle) const {
    const glm::uvec3 t = mesh_.triangles[triangle];
    return turned_ ? glm::uvec3(t.x, t.z, t.y) : t;
  }
  glm::dvec3 position(std::uint32_t vertex) const {
    return glm::dvec3(world_from_object_ * glm::dvec4(mesh_.positions[vertex], 1.0));
  }
  std::array<glm::dvec3, 3> triangle(std::size_t i) const {
    const glm::uvec3 t = indices(i);
    return {position(t.x), position(t.y), position(t.z)};
  }
  /// Unit vertex normal; only for meshes that have them.
  glm::dvec3 normal(std::uint32_t vertex) const;

 private:
  const TriangleMesh& mesh_;
  glm::dmat4 world_from_object_;
  glm::dmat3 normal_matrix_;
  bool turned_;
};

/// The sphere in world space: a similarity keeps it one.
Sphere placed_sphere(const Sphere& sphere, const Instance& instance);

/// The points center + x·a + y·b with x² + y² <= 1: the unit disk in world space. a × b points to the side of its
/// normal.
struct PlacedDisk {
  glm::dvec3 center, a, b;

  glm::dvec3 normal() const;
  double area() const;
  /// From the centre to the sides of its box.
  glm::dvec3 reach() const;
};
PlacedDisk placed_disk(const Instance& instance);

/// The side of a cylinder in world space: a similarity keeps it one.
struct PlacedCylinder {
  glm::dvec3 p0, p1;
  double radius;
  bool inward;  ///< its normal points toward the axis

  double area() const;
  /// From p0 and p1 to the sides of the boxes around the circles there.
  glm::dvec3 reach() const;
};
PlacedCylinder placed_cylinder(const Cylinder& cylinder, const Instance& instance);

/// Area of a triangle of the mesh in object space; 0 exactly if it has none in any instance.
double triangle_area(const TriangleMesh& mesh, const glm::uvec3& triangle);
/// Area of a triangle in squared units of its vertices.
double triangle_area(const std::array<glm::dvec3, 3>& p);

}  // namespace etendue
