#pragma once
/// Cells for the directions that a rough surface scatters to, in the space of the microfacets' normals: a narrow lobe
/// falls into a single cell of a grid of directions, but spreads over those of its normals in units of its roughness.

#include <optional>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace etendue {

/// A place in the grid: `height` in (−1, 1), positive for reflection and negative for transmission, `phi` an angle.
struct FacetCell {
  double height = 0;
  double phi = 0;
};

class FacetCells {
 public:
  /// For light from `wo`; `eta` is the relative index n_i/n_o of transmission, 1 where what passes is a mirror image of
  /// what is reflected. |height| = √ρ / (1 + √ρ), with ρ the
  /// slope of the normal in units of the roughness: even over the orders of magnitude, so that a diffuse base is seen
  /// besides a lobe of 10⁻³.
  FacetCells(const Roughness& roughness, const glm::dvec3& wo, double eta);

  FacetCell cell_of(const glm::dvec3& wi) const;

  struct Direction {
    glm::dvec3 wi{0.0};
    double solid_angle = 0;  ///< of wi, per d(height) dφ; 0 where no direction belongs to the cell
  };
  Direction direction_of(const FacetCell& cell) const;

 private:
  Roughness roughness_;
  glm::dvec3 wo_;  ///< turned to the side z > 0
  double eta_;
  bool turned_;
};

/// The roughness of a material with a lobe too narrow for a grid of directions.
std::optional<Roughness> narrow_roughness(const Bsdf& bsdf);

}  // namespace etendue
