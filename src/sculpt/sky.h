#pragma once
/// A latitude-longitude picture of the sky by day.

#include <cstdint>
#include <string>

namespace etendue::sculpt {

/// Writes a Radiance HDR file of width `2 · height`: a blue sky with a few thin clouds, hazy at the horizon and around
/// the sun, above dim ground. The sun has a radius of 1.5 degrees and is 35 degrees high, toward +X and a little toward
/// -Z.
void write_sky(std::uint32_t height, const std::string& title, const std::string& path);

}  // namespace etendue::sculpt
