#pragma once
/// Clear skies and their sun as pictures of all directions, after [Preetham1999]. +Y is up, −Z north, +X east.

#include <cstdint>
#include <memory>

#include <glm/glm.hpp>

#include "image/bitmap.h"

namespace etendue {

struct Daylight {
  double turbidity = 3.0;   ///< 1.9 … 10: how hazy the air is
  glm::dvec3 sun{0, 1, 0};  ///< unit, toward the sun, which must be above the horizon
  double sky_scale = 1.0;   ///< factors of the radiances; 0 leaves out the sky or the sun
  double sun_scale = 1.0;
  double sun_radius = 1.0;     ///< in radii of the real sun; its irradiance does not depend on it
  double ground_albedo = 0.0;  ///< of a matt ground below the horizon, lit by both
  std::uint32_t width = 1024;  ///< of the picture, which is half as high
};

/// Radiance of the sky toward the unit direction `w`, w.y > 0: linear Rec. 709, W·m⁻²·sr⁻¹·nm⁻¹, averaged over the
/// visible spectrum as Mitsuba does it, so that 1 is 683 · 106.857 cd/m². Without its scale.
glm::dvec3 sky_radiance(const Daylight& daylight, const glm::dvec3& w);
/// Radiance of the sun's disk through the atmosphere. Without its scale, and for its real radius.
glm::dvec3 sun_radiance(const Daylight& daylight);
/// Irradiance of a surface that faces the sun.
glm::dvec3 sun_irradiance(const Daylight& daylight);

/// The picture, for SkyPicture::Rows::bands.
std::shared_ptr<const Bitmap> make_daylight(const Daylight& daylight);

struct PlaceAndTime {
  double latitude = 0.0;   ///< degrees north
  double longitude = 0.0;  ///< degrees east
  double timezone = 0.0;   ///< hours that clocks are ahead of universal time
  int day_of_year = 81;    ///< 1 … 366
  double hour = 12.0;      ///< of the clock
};
/// Toward the sun, unit; to about a degree [Preetham1999, appendix A.6].
glm::dvec3 sun_direction(const PlaceAndTime& place);

}  // namespace etendue
