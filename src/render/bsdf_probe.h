#pragma once
/// A single material, the interface of device and reference to the tests of sampling. Directions are local
/// unit vectors (+Z is the shading normal) that point away from the surface; the contract of sample, eval and pdf is
/// that of shaders/bsdf/bsdf.glsl.

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

/// What `sample` returned.
struct BsdfDraw {
  glm::dvec3 wi{0.0};
  double pdf = 0;  ///< w.r.t. solid angle; of a delta lobe its discrete probability; 0: no sample
  glm::dvec3 weight{0.0};
  ProbeLobe lobe = ProbeLobe::none;
};

/// What `eval` and `pdf` returned.
struct BsdfValue {
  glm::dvec3 eval{0.0};  ///< f · |cos θ_i|
  double pdf = 0;
};

class BsdfProbe {
 public:
  virtual ~BsdfProbe() = default;
  virtual std::string device_name() const = 0;
  virtual std::string driver_name() const = 0;
  /// The samples [first, first + count) of the stream `seed`.
  virtual std::vector<BsdfDraw> sample(const glm::dvec3& wo, std::uint32_t seed, std::uint32_t first,
                                       std::uint32_t count) = 0;
  virtual std::vector<BsdfValue> evaluate(const glm::dvec3& wo, std::span<const glm::dvec3> wi) = 0;
};

using BsdfProbeFactory = std::function<std::unique_ptr<BsdfProbe>(const Bsdf& bsdf)>;

}  // namespace etendue
