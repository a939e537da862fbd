#include "formats/mitsuba/mitsuba_daylight.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/dialect/daylight.h"

namespace etendue {
namespace {

/// The sky's pole is +z in Mitsuba 3, +y in 0.6 and here.
glm::dmat3 mitsuba_from_sky(bool old) {
  return old ? glm::dmat3(1.0) : glm::dmat3({1, 0, 0}, {0, 0, 1}, {0, -1, 0});
}

int day_of_year(const MitsubaObject& object) {
  constexpr int kDaysBefore[] = {0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334};
  return kDaysBefore[object.integer("month") - 1] + static_cast<int>(object.integer("day"));
}

/// The direction toward the sun in the frame of our sky. If place and time are given, +x is south and +y is west in
/// Mitsuba 3.
glm::dvec3 sun_of(const MitsubaObject& object, bool old) {
  if (object.given("sun_direction")) return glm::transpose(mitsuba_from_sky(old)) * object.triple("sun_direction");
  const glm::dvec3 sun =
      sun_direction({.latitude = object.real("latitude"),
                     .longitude = object.real("longitude"),
                     .timezone = object.real("timezone"),
                     .day_of_year = day_of_year(object),
                     .hour = object.real("hour") + object.real("minute") / 60.0 + object.real("second") / 3600.0});
  // Here, +x is east and −z is north.
  return old ? sun : glm::transpose(mitsuba_from_sky(old)) * glm::dvec3(sun.z, -sun.x, sun.y);
}

}  // namespace

bool is_mitsuba_daylight(std::string_view type) {
  return type == "sky" || type == "sun" || type == "sunsky";
}

std::optional<Sky> read_mitsuba_daylight(const MitsubaObject& object, const MitsubaContext& context) {
  const bool old = context.document.version().starts_with("0.");
  context.missing.add(fmt::format("emitter {} (a sky by tables of coefficients)", object.type()), object.position(),
                      "Preetham's sky of the same sun and turbidity");
  const glm::dvec3 sun = sun_of(object, old);
  if (!(sun.y > 0.0)) {
    context.sink.error(object.position(), "the sun is below the horizon; give another direction or time");
    return std::nullopt;
  }
  constexpr double kLeast = 1.9, kMost = 10.0, kSunAngle = 0.533;
  Daylight daylight{.turbidity = std::clamp(object.real("turbidity"), kLeast, kMost), .sun = glm::normalize(sun)};
  daylight.sky_scale = object.type() == "sun" ? 0.0 : object.real("sky_scale") * object.real("scale");
  daylight.sun_scale = object.type() == "sky" ? 0.0 : object.real("sun_scale") * object.real("scale");
  daylight.sun_radius =
      object.given("sun_aperture") ? object.real("sun_aperture") / kSunAngle : object.real("sun_radius_scale");
  Sky sky;
  sky.picture = SkyPicture{.bitmap = make_daylight(daylight)};
  sky.world_from_sky = glm::dmat3(object.matrix("to_world", RotationAxes::unit)) * mitsuba_from_sky(old);
  return sky;
}

}  // namespace etendue
