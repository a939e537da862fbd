#pragma once
/// Object space → world space; docs/conventions.md, "Instances".

#include <array>
#include <cstdint>

#include "reference/ray.h"
#include "reference/shapes.h"
#include "reference/vec.h"
#include "scene/scene.h"

namespace etendue::reference {

/// Where an instance puts its shape, and which way round.
class Placement {
 public:
  explicit Placement(const Instance& instance);

  Vec3 point(const Vec3& p) const { return Vec3(matrix_ * glm::dvec4(p, 1.0)); }
  /// A unit normal: it stays perpendicular to the surface and on its side, unless the instance flips it.
  Vec3 normal(const Vec3& n) const;
  /// The interpolated vertex normal at barycentric weights `b` of triangle `i`; `ng` where there is none.
  Vec3 shading_normal(const TriangleMesh& mesh, std::uint32_t i, const Vec3& b, const Vec3& ng) const;
  /// A triangle's vertices by index, ordered so that their winding agrees with its normal.
  glm::uvec3 ordered(const glm::uvec3& triangle) const;
  /// A triangle of the mesh in world space, ordered like that.
  std::array<Vec3, 3> triangle(const TriangleMesh& mesh, std::uint32_t i) const;
  Sphere sphere(const Sphere& object) const;
  Ellipse disk() const;
  Tube cylinder(const Cylinder& object) const;
  /// The ray seen from object space. Its direction keeps its length's meaning: distances are those of the world.
  Ray to_object(const Ray& ray) const;
  /// Whether triangles are turned around: their second and third vertices change places in `triangle`.
  bool turned() const { return side_ < 0.0; }
  const glm::dmat4& matrix() const { return matrix_; }

 private:
  glm::dmat4 matrix_;
  glm::dmat3 object_from_world_;  ///< of directions
  glm::dmat3 cofactors_;  ///< of the upper 3 × 3, over the largest of them: det · inverse transpose, up to a factor
  bool flipped_ = false;
  double side_ = 1.0;  ///< what makes the cofactors keep normals on their side
};

}  // namespace etendue::reference
