#pragma once
/// Places and rays where so many primitives overlap that a walk through the tree takes long, or too long.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "compile/box.h"
#include "compile/normalization.h"
#include "scene/scene.h"

namespace etendue {

/// How many boxes of a scene's primitives a place or a ray is in. A ray has to test a primitive whose box it meets
/// before it has hit anything, whatever the tree. Primitives that leave no trace in the tree (find_twins) do not count.
class Crowding {
 public:
  explicit Crowding(const Scene& scene);

  std::size_t primitives() const { return boxes_.size(); }

  struct Place {
    glm::dvec3 at{0.0};        ///< world space
    std::size_t count = 0;     ///< boxes it is in
    std::size_t instance = 0;  ///< of one of them
  };
  /// The most crowded among the centres of 64 to 512 primitives, fewer where there are millions, chosen evenly: a heap
  /// of a thirtieth of all primitives is missed once in nine scenes or less. Nothing for a scene without primitives.
  std::optional<Place> find_place() const;

  /// Boxes that a ray from `origin` along `direction` (world space, not 0) meets within `distance` times its length.
  std::size_t count_along(const glm::dvec3& origin, const glm::dvec3& direction, double distance) const;

 private:
  Normalization normalization_;
  std::vector<Box> boxes_;  ///< normalised coordinates
  std::vector<std::uint32_t> instances_;
};

}  // namespace etendue
