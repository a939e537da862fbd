#pragma once
/// Finds places where so many primitives overlap that traversing the tree takes too long.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "compile/box.h"
#include "compile/normalization.h"
#include "scene/scene.h"

namespace etendue {

/// Counts the boxes of primitives that contain a point or meet a ray. Whatever the tree, a ray must test every
/// primitive whose box it meets before its first hit. Primitives that are left out of the tree (find_twins) do not
/// count.
class Crowding {
 public:
  explicit Crowding(const Scene& scene);

  std::size_t primitives() const { return boxes_.size(); }

  struct Place {
    glm::dvec3 at{0.0};        ///< world space
    std::size_t count = 0;     ///< number of boxes that contain it
    std::size_t instance = 0;  ///< instance of one of them
  };
  /// The most crowded place among the centres of 64 to 512 evenly chosen primitives (fewer if there are millions). A
  /// heap of a thirtieth of all primitives is missed in at most one of nine scenes. Nothing for a scene without
  /// primitives.
  std::optional<Place> find_place() const;

  /// The number of boxes that a ray from `origin` along `direction` (world space, not 0) meets within `distance` times
  /// the length of `direction`.
  std::size_t count_along(const glm::dvec3& origin, const glm::dvec3& direction, double distance) const;

 private:
  Normalization normalization_;
  std::vector<Box> boxes_;  ///< normalised coordinates
  std::vector<std::uint32_t> instances_;
};

}  // namespace etendue
