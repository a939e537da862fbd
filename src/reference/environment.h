#pragma once
/// Light from outside the scene; docs/conventions.md, "Environment".

#include <cstdint>
#include <optional>
#include <vector>

#include "reference/lights.h"
#include "reference/ray.h"
#include "reference/rng.h"
#include "scene/scene.h"

namespace etendue::reference {

/// A direction that was sampled.
struct EnvironmentSample {
  Vec3 wi{0.0};        ///< in the world, unit
  double pdf_w = 0.0;  ///< including the choice of the environment
  Vec3 radiance{0.0};
  std::uint32_t cell = 0;  ///< counted row by row
  /// A directional light, number `cell` of the scene's lights without extent: `pdf_w` is the probability of its choice,
  /// `radiance` its irradiance.
  bool delta = false;
};

class Environment {
 public:
  /// Includes directional lights. `lights_power` is the sum of luminance times area of everything else that emits.
  Environment(const Scene& scene, double lights_power);
  Environment() = default;

  /// Whether it is sampled: black environments without directional lights are not.
  bool is_sampled() const { return !rows_.empty() || !distant_.empty(); }
  /// The probability with which `sample` leaves the choice to the lights; 1 if the environment is black.
  double lights_prob() const { return is_sampled() ? lights_prob_ : 1.0; }

  /// Radiance that arrives along direction `w`, pointing away from the scene.
  Vec3 radiance(const Vec3& w) const;
  /// Chooses a direction, or nothing if a light must be chosen instead. To be called only if it is sampled.
  std::optional<EnvironmentSample> sample(const SampleRandom::Environment& random) const;
  /// The density with which `sample` finds `w`.
  double pdf_w(const Vec3& w) const;

 private:
  struct Row {
    double cos_upper = 1.0, cos_lower = -1.0;
    DiscreteChoice cells;  ///< empty if none has weight
  };
  struct Place {
    std::uint32_t row = 0, column = 0;
    double across = 0.0, down = 0.0;
  };
  Vec3 to_sky(const Vec3& w) const { return glm::transpose(world_from_sky_) * w; }
  Vec3 texel(std::int64_t row, std::uint32_t column) const;
  Place place(const Vec3& d) const;
  Vec3 radiance_at(const Place& place) const;
  double density(std::uint32_t row, std::uint32_t column) const;
  std::vector<double> make_picture_rows();
  std::vector<double> make_gradient_rows();

  Sky sky_;
  glm::dmat3 world_from_sky_{1.0};
  std::uint32_t columns_ = 1;
  std::vector<Row> rows_;
  struct Distant {
    std::uint32_t number;  ///< in Scene::delta_lights
    Vec3 wi, irradiance;
  };
  std::vector<Distant> distant_;
  DiscreteChoice choice_;  ///< of a row, then of a directional light; the last entry stands for the lights
  double lights_prob_ = 0.0;
};

}  // namespace etendue::reference
