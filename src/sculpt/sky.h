#pragma once
/// A picture of a day's sky, latitude-longitude.

#include <cstdint>
#include <string>

namespace etendue::sculpt {

/// Writes a Radiance HDR file of width `2 · height`: a blue sky, hazy at the horizon and around a sun of 1.5 degrees,
/// with a few thin clouds, over a dim ground. The sun stands 35 degrees high toward +X, a little toward -Z.
void write_sky(std::uint32_t height, const std::string& title, const std::string& path);

}  // namespace etendue::sculpt
