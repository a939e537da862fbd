#include "formats/nori/daylight_reader.h"

#include <array>
#include <bit>
#include <cmath>

#include <fmt/format.h>

namespace etendue {
namespace {

int day_of_year(std::int64_t month, std::int64_t day) {
  constexpr std::array<int, 12> kBefore{0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334};
  return kBefore[static_cast<std::size_t>(month - 1)] + static_cast<int>(day);
}

glm::dvec3 read_sun(const Object& object, Diagnostics& sink) {
  if (object.given("sunDirection")) {
    const auto direction = object.get<glm::dvec3>("sunDirection");
    for (const char* name : {"latitude", "longitude", "timezone", "month", "day", "hour"}) {
      if (object.given(name))
        sink.warning(object.position_of(name), fmt::format("\"{}\" has no effect with \"sunDirection\"", name));
    }
    if (glm::length(direction) > 0.0) return glm::normalize(direction);
    sink.error(object.position_of("sunDirection"), "the direction of the sun is 0 0 0; give one");
    return {0, 1, 0};
  }
  return sun_direction({.latitude = object.get<double>("latitude"),
                        .longitude = object.get<double>("longitude"),
                        .timezone = object.get<double>("timezone"),
                        .day_of_year = day_of_year(object.get<std::int64_t>("month"), object.get<std::int64_t>("day")),
                        .hour = object.get<double>("hour")});
}

}  // namespace

bool is_daylight(std::string_view type) {
  return type == "sky" || type == "sun" || type == "sunsky";
}

Daylight read_daylight(const Object& object, Diagnostics& sink) {
  const std::string_view type = object.plugin().type;
  Daylight daylight;
  daylight.turbidity = object.get<double>("turbidity");
  daylight.sky_scale = type == "sun" ? 0.0 : object.get<double>("skyScale");
  daylight.sun_scale = type == "sky" ? 0.0 : object.get<double>("sunScale");
  if (type != "sky") daylight.sun_radius = object.get<double>("sunRadiusScale");
  daylight.ground_albedo = object.get<double>("groundAlbedo");
  daylight.width = static_cast<std::uint32_t>(object.get<std::int64_t>("resolution"));
  if (!std::has_single_bit(daylight.width))
    sink.error(object.position_of("resolution"),
               fmt::format("the resolution {} is not a power of two; use {} or {}", daylight.width,
                           std::bit_floor(daylight.width), std::bit_ceil(daylight.width)));
  daylight.sun = read_sun(object, sink);
  if (!(daylight.sun.y > 0.0)) {
    sink.error(object.position_of(object.given("sunDirection") ? "sunDirection" : "hour"),
               fmt::format("the sun is {:.1f} degrees below the horizon; the model has no night: move it up",
                           -std::asin(daylight.sun.y) * 57.29577951308232));
    daylight.sun = {0, 1, 0};
  }
  return daylight;
}

}  // namespace etendue
