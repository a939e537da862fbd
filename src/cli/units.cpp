#include "cli/units.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/core.h>

#include "core/errors.h"
#include "scene/limits.h"

namespace etendue::cli {
namespace {

template <typename T>
std::optional<T> parse_number(std::string_view text) {
  T value{};
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || stop != text.data() + text.size()) return {};
  return value;
}

// A decimal number without sign and exponent, finite.
std::optional<double> parse_plain(std::string_view text) {
  if (text.find_first_not_of("0123456789.") != std::string_view::npos) return {};
  const auto value = parse_number<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

[[noreturn]] void refuse(const char* option, const std::string& text, const char* expected) {
  throw Error(ErrorKind::usage, fmt::format("'{} {}' is not {}.", option, text, expected));
}

}  // namespace

double parse_duration(const char* option, const std::string& text) {
  struct Unit {
    std::string_view name;
    double seconds;
  };
  constexpr Unit kUnits[] = {{"ms", 1e-3}, {"s", 1.0}, {"m", 60.0}, {"h", 3600.0}, {"d", 86400.0}};
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  for (const Unit& unit : kUnits) {
    if (std::string_view(text).substr(digits) != unit.name) continue;
    const auto value = parse_plain(std::string_view(text).substr(0, digits));
    // Beyond a thousand years the clock's arithmetic would overflow.
    if (value && *value > 0.0 && *value * unit.seconds < 3e10) return *value * unit.seconds;
  }
  refuse(option, text, "a duration above zero with its unit ms, s, m, h or d; write for example 30s, 10m or 1.5h");
}

double parse_moment(const char* option, const std::string& text) {
  if (const auto seconds = parse_plain(text); seconds && *seconds < 3e10) return *seconds;
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  if (parse_plain(text.substr(0, digits)) == 0.0) return 0.0;
  return parse_duration(option, text);
}

double parse_fraction(const char* option, const std::string& text) {
  const bool percent = text.ends_with('%');
  const auto value = parse_plain(std::string_view(text).substr(0, text.size() - (percent ? 1 : 0)));
  const double fraction = value.value_or(0.0) / (percent ? 100.0 : 1.0);
  if (fraction > 0.0 && fraction < 1.0) return fraction;
  refuse(option, text, "a fraction between 0 and 1; write for example 1% or 0.01");
}

SampleRange parse_frames(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) {
    const auto begin = parse_number<std::uint32_t>(std::string_view(text).substr(0, colon));
    const auto end = parse_number<std::uint32_t>(std::string_view(text).substr(colon + 1));
    if (begin && end && *begin < *end) return {*begin, *end};
  }
  refuse("--frames", text,
         "a range A:B of frames with 0 <= A < B < 2^32 (B itself is not rendered); write for example "
         "0:48");
}

SampleRange parse_samples(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon != std::string::npos) {
    const auto begin = parse_number<std::uint32_t>(std::string_view(text).substr(0, colon));
    const auto end = parse_number<std::uint32_t>(std::string_view(text).substr(colon + 1));
    if (begin && end && *begin < *end) return {*begin, *end};
  }
  refuse("--samples", text,
         "a range A:B of sample indices with 0 <= A < B < 2^32 (B itself is not rendered); write for example 0:64");
}

Size parse_size(const std::string& text) {
  const std::size_t x = text.find('x');
  if (x != std::string::npos) {
    const auto width = parse_number<std::uint32_t>(std::string_view(text).substr(0, x));
    const auto height = parse_number<std::uint32_t>(std::string_view(text).substr(x + 1));
    const auto good = [](const auto& side) { return side && *side >= 1 && *side <= 65536; };
    if (good(width) && good(height)) {
      const std::int64_t pixels = std::int64_t{*width} * *height;
      if (pixels <= kMaxPixels) return {*width, *height};
      throw Error(ErrorKind::usage,
                  fmt::format("'--size {}' has {} pixels; at most {} are supported.", text, pixels, kMaxPixels));
    }
  }
  refuse("--size", text, "WIDTHxHEIGHT in pixels from 1 to 65536; write for example --size 800x600");
}

}  // namespace etendue::cli
