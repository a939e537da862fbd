#pragma once
/// All surfaces that emit, and the choice among them; docs/conventions.md, "Discrete choices" and
/// "Emitters".

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "reference/discrete_choice.h"
#include "reference/light_tree.h"
#include "reference/mesh_light.h"
#include "reference/placement.h"
#include "reference/ray.h"
#include "reference/rng.h"
#include "scene/lamp_parts.h"
#include "scene/scene.h"

namespace etendue::reference {

/// An instance with an emitter.
struct AreaLight {
  std::uint32_t instance = 0;
  Placement placement;
  double area = 0.0;                        ///< of the whole instance, in world space
  DiscreteChoice triangles;                 ///< empty for shapes other than meshes
  std::shared_ptr<const MeshLight> shared;  ///< for an instance of a shared mesh, instead of `triangles`
  bool two_sided = false;                   ///< also emits behind
  LampParts parts = {};                     ///< then `triangles` chooses one of these instead

  const DiscreteChoice& choice() const { return shared ? shared->triangles() : triangles; }
  /// What is chosen for light from a point of the surface: a triangle, or a part of one.
  std::uint32_t entry_at(std::uint32_t primitive, const Vec3& weights) const;
  /// The triangle of such an entry.
  std::uint32_t triangle_of(std::uint32_t entry) const;
  /// Along a side of the triangle of such an entry; 1 if it is not divided.
  std::uint32_t cells_of(std::uint32_t entry) const;
};

/// A point on a light, as seen from a point `from`.
struct LightSample {
  std::uint32_t instance = 0;
  std::uint32_t primitive = 0;
  Surface surface;         ///< the light's surface there
  Vec3 wi{0.0};            ///< unit, from `from` toward it
  double pdf_w = 0.0;      ///< solid-angle density, including the choice of the light; 0: no light arrives
  double pdf_w_mis = 0.0;  ///< the density that multiple-importance weights use
  Vec3 radiance{0.0};      ///< toward `from`
  /// A light without extent, with the number `primitive` in the scene: `pdf_w` is the probability of its choice,
  /// `radiance` its intensity divided by the squared distance. No other strategy finds it.
  bool delta = false;
};

class Lights {
 public:
  explicit Lights(const Scene& scene);
  Lights() = default;

  bool empty() const { return choice_.empty(); }
  /// Sum of luminance times area, plus, for lights without extent, power divided by π.
  double power() const { return power_; }
  /// Chooses a light for a surface at `from` with shading normal `ns`, and a point on it; nothing if no light can
  /// contribute. Must not be called if there are no lights.
  std::optional<LightSample> sample(const Scene& scene, const Vec3& from, const Vec3& ns,
                                    const SampleRandom::Light& random) const;
  /// The probability with which `sample` chooses a primitive, or the part of it in which the point with these weights
  /// of its vertices lies.
  double prob(const Vec3& from, const Vec3& ns, std::uint32_t instance, std::uint32_t primitive,
              const Vec3& weights) const;
  /// The density with which `sample` finds `at`, for multiple-importance weights; 0 if there is no light.
  double pdf_w_mis(const Scene& scene, const Vec3& from, const Vec3& ns, const Surface& at) const;

 private:
  /// A chosen primitive. Densities of points on it are w.r.t. area.
  struct Chosen {
    const AreaLight* light = nullptr;
    std::optional<std::uint32_t> delta = {};  ///< instead: the number of a light without extent
    std::uint32_t primitive = 0;
    Vec2 corner{0.0};    ///< of the cell of its sampling square in which the point lies,
    double side = 1.0;   ///< and the length of the cell's sides
    double prob = 0.0;   ///< of a sphere
    double pdf_a = 0.0;  ///< of a triangle
    double pdf_a_mis = 0.0;
  };
  std::optional<Chosen> choose(const Scene& scene, const Vec3& from, const Vec3& ns,
                               const SampleRandom::Light& random) const;
  static LightSample sample_delta(const Scene& scene, std::uint32_t number, double prob, const Vec3& from);
  static void choose_part(const AreaLight& light, std::uint32_t entry, Chosen& chosen);
  static Chosen choose_shared(const Scene& scene, const AreaLight& light, double prob, std::uint32_t word);
  void sample_triangle(const TriangleMesh& mesh, const Chosen& chosen, const Vec3& from,
                       const SampleRandom::Light& random, LightSample& sample) const;
  void sample_round(const Shape& shape, Chosen chosen, const Vec3& from, const SampleRandom::Light& random,
                    LightSample& sample) const;
  static void see_from(const Vec3& from, const Chosen& chosen, bool shared, LightSample& sample);

  std::vector<AreaLight> lights_;
  std::vector<std::uint32_t>
      deltas_;             ///< lights without extent that have a position; they follow lights_ in the choice
  LightTree tree_;         ///< empty if lights are chosen by power
  DiscreteChoice choice_;  ///< index into lights_
  double power_ = 0.0;
  std::vector<std::optional<std::size_t>> of_instance_;  ///< instance → index into lights_
};

/// Radiance that a surface sends toward `wo`.
Vec3 emitted_radiance(const Scene& scene, const Surface& surface, const Vec3& wo);

}  // namespace etendue::reference
