#pragma once
/// Estimators of the radiance along a camera ray, and the record of what they decided.

#include <optional>
#include <vector>

#include "reference/bsdf.h"
#include "reference/rng.h"
#include "reference/world.h"
#include "render/renderer.h"

namespace etendue::reference {

/// Folds a sample's decisions into its signature and, if requested, records them one by one; docs/conventions.md, "Path
/// signature".
class DecisionLog {
 public:
  static constexpr std::size_t kMaxVertices = 256;

  /// Decisions are also appended to `vertices` unless it is null.
  explicit DecisionLog(std::vector<PathVertex>* vertices = nullptr) : vertices_(vertices) {}

  void segment(const Ray& ray, const std::optional<Surface>& hit);
  void light(const LightSample& sample, bool contributed);
  void environment(const EnvironmentSample& sample, bool contributed);
  void lobe(Lobe lobe);
  void roulette(bool survived);
  /// The radiance gathered so far.
  void radiance(const Vec3& rgb);

  std::uint32_t signature() const { return hash_; }
  std::uint32_t segments() const { return segments_; }

 private:
  void light(std::uint32_t instance, std::uint32_t primitive, bool contributed);
  void fold(std::uint32_t word) { hash_ = (hash_ ^ word) * 0x01000193u; }
  /// The vertex being recorded, or null.
  PathVertex* vertex() const;

  std::uint32_t hash_ = 0x811c9dc5u;
  std::uint32_t segments_ = 0;
  std::vector<PathVertex>* vertices_;
};

/// Path tracing (integrators `path` and `whitted`) [Kajiya1986] as in docs/conventions.md, "Path estimator".
Vec3 path_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log);

/// Light from emitters and sky reflected by the first surface (integrator `direct`).
Vec3 direct_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log);

/// Integrators that look only at the first surface: `normals` in both forms, `depth`, `simple`, `ao` and `av`;
/// docs/conventions.md, "Integrators".
Vec3 first_hit_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log);

/// The value of one AOV for a camera ray: docs/conventions.md, "AOVs".
Vec3 aov_value(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log);

/// The weight of a sample of an AOV; `weight` is that of a sample of the picture.
double aov_weight(const Scene& scene, double weight, std::uint32_t sample);

}  // namespace etendue::reference
