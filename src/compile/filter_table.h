#pragma once
/// Reconstruction filters as tables for sampling: docs/conventions.md, "Camera and filter".

#include <vector>

#include "scene/scene.h"

namespace etendue {

struct FilterTable {
  std::vector<float> knots;  ///< inverse CDF of |filter| at i/kFilterSteps, in pixels; empty for the box of one pixel
  double weight = 1.0;       ///< ∫|f| / ∫f
  bool turns_negative = false;
  double zero = 0.0;        ///< |x| beyond which the filter is negative, if its sign changes once
  bool alternates = false;  ///< the sign changes at every whole number of pixels instead
};

FilterTable make_filter_table(const ReconstructionFilter& filter);

}  // namespace etendue
