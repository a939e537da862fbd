#pragma once
/// A shared mesh as a light: what all of its instances have in common; docs/conventions.md, "Shared meshes".

#include <vector>

#include "reference/discrete_choice.h"
#include "reference/light_tree.h"
#include "reference/placement.h"

namespace etendue::reference {

class MeshLight {
 public:
  explicit MeshLight(const TriangleMesh& mesh);

  /// By area in object space.
  const DiscreteChoice& triangles() const { return triangles_; }
  double area() const { return area_; }  ///< in object space
  /// The weight of an instance: its area in the world where axes are scaled alike, at least that otherwise.
  double placed_area(const Placement& placement) const;
  /// An instance as one leaf of the light tree, of radiance 1.
  LightLeaf leaf(const Placement& placement) const;

 private:
  void find_cone(const TriangleMesh& mesh);

  DiscreteChoice triangles_;
  double area_ = 0.0;
  glm::dmat3 spread_{0.0};  ///< sum of area times the outer square of the normal
  Vec3 lower_{INFINITY}, upper_{-INFINITY};
  Vec3 axis_{0.0};  ///< of the cone that holds all normals; 0: there is none narrower than a half space
  double cos_cone_ = -1.0;
};

}  // namespace etendue::reference
