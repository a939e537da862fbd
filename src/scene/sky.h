#pragma once
/// Light from outside the scene; docs/conventions.md, "Environment".

#include <cstdint>
#include <memory>
#include <optional>

#include <glm/glm.hpp>

#include "image/bitmap.h"

namespace etendue {

/// Radiance of all directions as a latitude-longitude picture, +Y up.
struct SkyPicture {
  /// Where the rows of texels are between the poles.
  enum class Rows : std::uint32_t {
    bands,   ///< in the middle of bands of equal height, the first half a band below the north pole
    circles  ///< at equal distances from pole to pole, both included
  };
  std::shared_ptr<const Bitmap> bitmap;  ///< grey or colour; alpha is ignored
  double scale = 1.0;                    ///< radiance of a (decoded) 1 in the bitmap
  Rows rows = Rows::bands;

  /// Radiance of a texel, rounded to single precision.
  glm::vec3 radiance(std::uint32_t x, std::uint32_t y) const;
};

/// The light seen by a ray that leaves the scene in direction w of the sky's frame: the picture if there is one,
/// otherwise mix(horizon, top, clamp(w.y, 0, 1)).
struct Sky {
  glm::dvec3 top{0.0};
  glm::dvec3 horizon{0.0};
  std::optional<SkyPicture> picture;
  glm::dmat3 world_from_sky{1.0};  ///< rotation, reflection and uniform scale, which is ignored
};

/// Whether the sky is black.
bool is_dark(const Sky& sky);

struct SkyStatistics {
  double largest = 0.0;   ///< component of radiance; infinite if one is not finite
  double smallest = 0.0;  ///< negative if one is
  double mean = 0.0;      ///< over all directions, of the largest component
};
SkyStatistics sky_statistics(const SkyPicture& picture);

}  // namespace etendue
