#pragma once
/// Cells in which the chi-square test counts the samples of one material, and how many it expects there.

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "render/bsdf_probe.h"
#include "validate/facet_cells.h"
#include "validate/sphere_quadrature.h"

namespace etendue {

/// A delta lobe as theory has it.
struct DeltaLobe {
  ProbeLobe kind;
  glm::dvec3 wi;
  double prob;
  glm::dvec3 weight;
};
/// In the material's own frame.
std::vector<DeltaLobe> delta_lobes(const Bsdf& bsdf, const glm::dvec3& wo);

/// The grid of a material's directions, in its own frame: even over the sphere, or over the microfacets' normals of a
/// narrow lobe.
class SampleGrid {
 public:
  SampleGrid(const Bsdf& bsdf, const glm::dvec3& wo, std::uint32_t resolution);

  std::size_t cell_count() const { return static_cast<std::size_t>(rings_) * sectors_; }
  std::size_t cell_of(const glm::dvec3& wi) const;
  /// Integrals over the cells of a density w.r.t. solid angle.
  std::vector<double> integrate(const SphereDensity& density) const;
  /// The same of one cell by 128 × 128 points: finds corners that the adaptive rule misses.
  double integrate_finely(const SphereDensity& density, std::size_t cell) const;
  bool narrow() const { return facets_.has_value(); }

 private:
  SphereDensity over_cells(const SphereDensity& density) const;

  int rings_, sectors_;
  std::optional<FacetCells> facets_;
};

/// Counts of one material's samples: the cells of its grid, then one per delta lobe, then the samples without a
/// direction.
class SampleCounts {
 public:
  SampleCounts(SampleGrid grid, std::vector<DeltaLobe> lobes)
      : grid_(std::move(grid)), lobes_(std::move(lobes)), counts_(grid_.cell_count() + lobes_.size() + 1) {}

  /// `draw` has its direction in the material's frame.
  void add(const BsdfDraw& draw);
  const SampleGrid& grid() const { return grid_; }
  const std::vector<double>& counts() const { return counts_; }
  const std::vector<DeltaLobe>& lobes() const { return lobes_; }
  /// Largest difference of a delta sample from its closed form.
  double delta_error() const { return delta_error_; }

 private:
  void add_delta(const BsdfDraw& draw);

  SampleGrid grid_;
  std::vector<DeltaLobe> lobes_;
  std::vector<double> counts_;
  double delta_error_ = 0;
};

}  // namespace etendue
