#include "sculpt/sky.h"

#include <algorithm>
#include <span>

#include <fmt/format.h>

#include "image/files.h"
#include "sculpt/vec.h"

namespace etendue::sculpt {
namespace {

constexpr Vec3 kTowardSun{0.67, 0.574, -0.47};
constexpr double kSunRim = 3.4e-4;  // 1 − cos of 1.5 degrees: larger than the real sun, for soft shadows

/// Smoothly interpolated values of a lattice.
double noise(double x, double y) {
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto at = [&](int i, int j) {
    return signed_unit(hash(static_cast<std::uint32_t>(static_cast<std::int64_t>(x0) + i),
                            static_cast<std::uint32_t>(static_cast<std::int64_t>(y0) + j), 7));
  };
  const double a = smoothstep(0.0, 1.0, x - x0), b = smoothstep(0.0, 1.0, y - y0);
  return mix(mix(at(0, 0), at(1, 0), a), mix(at(0, 1), at(1, 1), a), b);
}

/// How much cloud, from 0 to 1, a high layer has in direction d.
double clouds(const Vec3& d) {
  if (d.y < 0.02) return 0.0;
  double x = 1.3 * d.x / d.y, y = 0.8 * d.z / d.y, sum = 0.0, weight = 1.0;
  for (int octave = 0; octave < 5; ++octave) {
    sum += weight * noise(x, y);
    x = 2.03 * x + 5.2;
    y = 2.11 * y - 3.7;
    weight *= 0.55;
  }
  return smoothstep(0.05, 1.1, sum) * smoothstep(0.02, 0.25, d.y);
}

Vec3 radiance(const Vec3& d) {
  const double from_sun = 1.0 - dot(d, normalize(kTowardSun));
  if (d.y < 0.0) return (1.0 - 0.5 * smoothstep(0.0, 0.6, -d.y)) * Vec3{0.16, 0.145, 0.12};
  const double height = std::sqrt(d.y);
  const Vec3 zenith{0.10, 0.22, 0.52}, horizon{0.62, 0.70, 0.78};
  Vec3 sky = (1.0 - height) * horizon + height * zenith;
  const double haze = 0.02 / (0.02 + from_sun);
  sky = sky + haze * Vec3{1.1, 0.95, 0.75} + 0.08 / (0.2 + from_sun) * Vec3{0.5, 0.5, 0.5};
  const double cloud = 0.75 * clouds(d);
  sky = (1.0 - cloud) * sky + cloud * (0.85 + 2.0 * haze) * Vec3{1.0, 0.97, 0.93};
  return sky + (1.0 - smoothstep(0.85, 1.0, from_sun / kSunRim)) * Vec3{1750.0, 1540.0, 1240.0};
}

/// Appends three mantissas and their common exponent plus 128 [Ward1991].
void append(std::string& bytes, const Vec3& color) {
  const double largest = std::max({color.x, color.y, color.z});
  int exponent = 0;
  std::frexp(largest, &exponent);
  const double scale = std::ldexp(256.0, -exponent);
  for (const double component : {color.x, color.y, color.z}) bytes += static_cast<char>(std::floor(component * scale));
  bytes += static_cast<char>(exponent + 128);
}

}  // namespace

void write_sky(std::uint32_t height, const std::string& title, const std::string& path) {
  const std::uint32_t width = 2 * height;
  std::string bytes = fmt::format("#?RADIANCE\n# {}\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", title, height, width);
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) {
      const double turn = (x + 0.5) / width, half_turn = 0.5 * (y + 0.5) / height;
      const double sine = sin_turns(half_turn);
      append(bytes, radiance(normalize({sine * sin_turns(turn), cos_turns(half_turn), -sine * cos_turns(turn)})));
    }
  }
  write_file_atomically(path, std::as_bytes(std::span(bytes.data(), bytes.size())));
}

}  // namespace etendue::sculpt
