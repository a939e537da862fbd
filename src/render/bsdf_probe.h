#pragma once
/// A material on a patch (scene/test_patch.h), the interface of device and reference to the tests of sampling.
/// Directions are unit vectors of the world that point away from the patch, whose normal is +Z; the contract of sample,
/// eval and pdf is that of shaders/bsdf/bsdf.glsl.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace etendue {

/// Lobes as folded into path signatures.
enum class ProbeLobe : std::uint32_t {
  none = 0,
  diffuse = 1,
  delta_reflection = 2,
  delta_transmission = 3,
  glossy_reflection = 4,
  glossy_transmission = 5,
  passed = 6,
  diffuse_transmission = 7
};
inline bool is_delta(ProbeLobe lobe) {
  return lobe == ProbeLobe::delta_reflection || lobe == ProbeLobe::delta_transmission;
}

/// What `sample` returned. Where an adapter lets light pass, lobe `passed`, −wo, pdf and weight 1.
struct BsdfDraw {
  glm::dvec3 wi{0.0};
  double pdf = 0;  ///< w.r.t. solid angle; of a delta lobe its discrete probability; 0: no sample
  /// 0 where a map has turned the normal and the direction is on different sides of both: such samples carry no light,
  /// but have been drawn.
  glm::dvec3 weight{0.0};
  ProbeLobe lobe = ProbeLobe::none;
};

/// What `eval` and `pdf` returned.
struct BsdfValue {
  glm::dvec3 eval{0.0};  ///< f · |cos θ_i|
  double pdf = 0;
};

/// A direction, and the number of a sample: adapters decide as they do for that sample.
struct BsdfQuery {
  glm::dvec3 wi{0.0};
  std::uint32_t sample = 0;
};

class BsdfProbe {
 public:
  virtual ~BsdfProbe() = default;
  virtual std::string device_name() const = 0;
  virtual std::string driver_name() const = 0;
  /// The samples [first, first + count) of the stream `seed`: those of the path estimator at its first vertex, in
  /// pixel 0.
  virtual std::vector<BsdfDraw> sample(const glm::dvec3& wo, std::uint32_t seed, std::uint32_t first,
                                       std::uint32_t count) = 0;
  enum class Part { mixture, chosen };
  /// Values of what the adapters choose for samples of the stream `seed`: the mixture that the path estimator uses, or
  /// the chosen material alone. 0 where it is black or light passes.
  virtual std::vector<BsdfValue> evaluate(const glm::dvec3& wo, std::uint32_t seed, std::span<const BsdfQuery> queries,
                                          Part part) = 0;
};

/// Makes the probe of the material on a patch.
using BsdfProbeFactory = std::function<std::unique_ptr<BsdfProbe>(const Scene& patch)>;

}  // namespace etendue
