#pragma once
/// Durations, fractions, sizes and sample ranges as people write them on the command line. Every function throws
/// Error(usage) that names the option, the text and an example.

#include <string>

#include "render/renderer.h"

namespace etendue::cli {

/// Seconds, > 0: "30s", "10m", "1.5h", "2d", "200ms"; a number without a unit is an error.
double parse_duration(const char* option, const std::string& text);
/// Seconds, >= 0: the same, and numbers without a unit.
double parse_moment(const char* option, const std::string& text);
/// A fraction in (0, 1): "1%" or "0.01".
double parse_fraction(const char* option, const std::string& text);
/// "A:B" with A < B.
SampleRange parse_samples(const std::string& text);
/// The same of frames.
SampleRange parse_frames(const std::string& text);

/// Width and height in pixels.
struct Size {
  std::uint32_t width = 0, height = 0;
};
/// "800x600".
Size parse_size(const std::string& text);

}  // namespace etendue::cli
