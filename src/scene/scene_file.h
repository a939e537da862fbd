#pragma once
/// What a file can hold: a scene, or a test of one.

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "scene/scene.h"

namespace etendue {

/// A material under test, with a name for the report.
struct TestBsdf {
  Scene patch;              ///< the material on its own, see add_test_patch()
  std::string name;         ///< the type and its position in the file, "diffuse 1"
  SourcePosition position;  ///< the <bsdf> tag
};

/// `<test type="ttest">`, of one of two kinds. With scenes: the mean luminance of each against one reference each. With
/// bsdfs: the albedo (mean luminance of the sampling weight) of each bsdf at each angle of incidence; `references` runs
/// over the angles of the first bsdf, then of the second, and so on.
struct TTest {
  double significance_level = 0.01;
  std::uint64_t sample_count =
      100000;  ///< camera samples per scene, over the whole film; or samples per bsdf and angle
  std::vector<double> references;
  std::vector<Scene> scenes;
  std::vector<double> angles;  ///< degrees from the normal, in [0, 180] without 90
  std::vector<TestBsdf> bsdfs;
};

/// `<test type="chi2test">`: does `sample` of each bsdf follow `pdf`?
struct Chi2Test {
  double significance_level = 0.01;
  std::uint32_t resolution = 10;   ///< cells in cos θ; twice as many in φ
  double min_exp_frequency = 5.0;  ///< cells that expect fewer samples are pooled
  std::uint64_t sample_count = 0;  ///< per test; 0: 5000 for each cell
  std::uint32_t test_count = 5;    ///< directions of incidence per bsdf, and per angle where there are any
  /// Degrees from the normal, in [0, 180] without 90; empty: directions at random on the sides the bsdf is lit from.
  std::vector<double> angles;
  std::vector<TestBsdf> bsdfs;
};

/// What a file can hold.
using SceneFile = std::variant<Scene, TTest, Chi2Test>;

}  // namespace etendue
