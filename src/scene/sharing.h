#pragma once
/// Which instances show a mesh that is stored once, in object space, for all of them: docs/conventions.md, "Shared
/// meshes".

#include <cstddef>
#include <vector>

#include "scene/scene.h"

namespace etendue {

/// Number of primitives, counted instance by instance, up to which a scene is flattened into world space: one tree is
/// walked faster than two levels.
inline constexpr std::size_t kFlattenAtMost = std::size_t{1} << 20;
/// Minimum number of triangles for a mesh to get its own tree; an instance takes as much memory as a few triangles.
inline constexpr std::size_t kLeastShared = 32;
/// Largest condition of a transform (see transform_condition) for transforming rays into object space: they lose that
/// many digits.
inline constexpr double kMostCondition = 256.0;
/// Largest ratio, approximately, of the scales of two axes: their squares must fit into single precision.
inline constexpr double kMostRatio = 0x1p40;

/// The largest row sum of |M| |M⁻¹|, with M the linear part: how much rounding in object space is magnified in the
/// world, in whatever units. 1 for axis-aligned scaling, at most 3 for a rotation.
double transform_condition(const glm::dmat4& world_from_object);

/// The decision for a whole scene. Both renderers follow it, because it determines how lights are chosen.
class Sharing {
 public:
  explicit Sharing(const Scene& scene);

  bool any() const { return any_; }
  /// Whether some instance shows a shape's shared copy.
  bool has_shape(std::size_t shape) const { return any_ && shapes_[shape]; }
  /// Whether an instance does.
  bool has_instance(std::size_t instance) const { return any_ && instances_[instance]; }

 private:
  bool any_ = false;
  std::vector<bool> shapes_, instances_;
};

}  // namespace etendue
