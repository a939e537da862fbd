#pragma once
/// Reconstruction filters, realised by sampling: each sample belongs to one pixel; docs/conventions.md, "Camera and
/// filter".

#include <vector>

#include "scene/scene.h"

namespace etendue::reference {

/// Value of the (unnormalised) filter at `x` pixels from its centre. Sources: [Mitchell1988], [Turkowski1990].
double filter_value(const ReconstructionFilter& filter, double x);
/// Half the width of the filter's support, pixels.
double filter_radius(const ReconstructionFilter& filter);

/// Samples one axis of the filter in proportion to its absolute value.
class FilterSampler {
 public:
  static constexpr int kIntervals = 1024;

  explicit FilterSampler(const ReconstructionFilter& filter);

  struct Sample {
    double offset;  ///< pixels from the pixel's centre
    double weight;  ///< ±∫|f|/∫f with the sign of the filter there
  };
  Sample sample(double u) const;  ///< u in [0,1)

  /// Inverse CDF of |filter| at i/1024, i = 0…1024; empty for the box of one pixel.
  const std::vector<double>& knots() const { return knots_; }
  /// ∫|f| / ∫f
  double normalization() const { return normalization_; }

 private:
  bool is_pixel() const;

  ReconstructionFilter filter_;
  std::vector<double> knots_;
  double normalization_ = 1.0;
};

}  // namespace etendue::reference
