#pragma once
/// Single rays without shading: the hits found by a renderer's tree, and the time they take. Measured by src/bench.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace etendue {

/// The map from world space to normalised scene coordinates: p ↦ (p − center) · scale.
struct Placement {
  glm::dvec3 center{0.0};
  double scale = 1.0;
};

/// A ray in normalised scene coordinates; hits count in the open interval (t_min, t_max).
struct CastRay {
  glm::vec3 o{0.0f};
  float t_min = 0.0f;
  glm::vec3 d{0.0f};  ///< unit length, up to rounding
  float t_max = 0.0f;
};

struct CastHit {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  float t = 0.0f;                  ///< meaningless if any hit was requested
  std::uint32_t instance = kNone;  ///< kNone: no hit
  std::uint32_t primitive = 0;     ///< triangle in the mesh, 0 for a sphere
  std::uint32_t steps = 0;         ///< nodes and primitives visited; 0 if they are not counted
};

enum class RayQuery : std::uint8_t {
  closest,  ///< the nearest hit
  any,      ///< whether there is one, as for a shadow ray
};

/// Holds one set of rays at a time.
class RayCaster {
 public:
  virtual ~RayCaster() = default;
  virtual std::string device_name() const = 0;
  virtual std::string driver_name() const = 0;
  /// The space of the rays' coordinates.
  virtual Placement placement() const = 0;
  /// The largest number of rays that `load` accepts.
  virtual std::size_t max_rays() const = 0;
  /// The number of rays that keeps the device busy long enough for a measurement.
  virtual std::size_t enough_rays() const = 0;

  virtual void load(std::span<const CastRay> rays) = 0;
  /// Casts the loaded rays; returns the time in seconds, without transfers.
  virtual double cast(RayQuery query) = 0;
  /// The hits of the last `cast`, in the order of the rays.
  virtual std::vector<CastHit> hits() = 0;
};

using RayCasterFactory = std::function<std::unique_ptr<RayCaster>(const Scene& scene)>;

}  // namespace etendue
