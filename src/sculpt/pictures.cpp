#include "sculpt/pictures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

namespace etendue::sculpt {
namespace {

using glm::dvec3;

/// A random number in [0,1) for a lattice point, with the hash of [Jarzynski2020].
double lattice(std::int64_t x, std::int64_t y, std::uint32_t seed) {
  std::uint32_t v[3] = {static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), seed};
  for (std::uint32_t& word : v) word = word * 1664525u + 1013904223u;
  for (int round = 0; round < 2; ++round) {
    v[0] += v[1] * v[2], v[1] += v[2] * v[0], v[2] += v[0] * v[1];
    if (round == 0)
      for (std::uint32_t& word : v) word ^= word >> 16;
  }
  return static_cast<double>(v[0] >> 8) * 0x1p-24;
}

/// Smooth noise in [0,1] that repeats every `period_x` and `period_y` cells.
double noise(double x, double y, std::int64_t period_x, std::int64_t period_y, std::uint32_t seed) {
  const double cell_x = std::floor(x), cell_y = std::floor(y);
  const auto fade = [](double t) { return t * t * (3.0 - 2.0 * t); };
  const auto value = [&](int i, int j) {
    const auto around = [](std::int64_t k, std::int64_t n) { return (k % n + n) % n; };
    return lattice(around(static_cast<std::int64_t>(cell_x) + i, period_x),
                   around(static_cast<std::int64_t>(cell_y) + j, period_y), seed);
  };
  const double fx = fade(x - cell_x), fy = fade(y - cell_y);
  return (1.0 - fy) * ((1.0 - fx) * value(0, 0) + fx * value(1, 0)) +
         fy * ((1.0 - fx) * value(0, 1) + fx * value(1, 1));
}

double fractal(double u, double v, std::int64_t cells_u, std::int64_t cells_v, int octaves, std::uint32_t seed) {
  double sum = 0.0, weight = 0.5;
  for (int i = 0; i < octaves; ++i, weight *= 0.5, cells_u *= 2, cells_v *= 2)
    sum += weight * noise(u * static_cast<double>(cells_u), v * static_cast<double>(cells_v), cells_u, cells_v,
                          seed + static_cast<std::uint32_t>(i));
  return sum / (1.0 - std::pow(0.5, octaves));
}

double step(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Six boards with rings along u.
dvec3 wood(double u, double v) {
  constexpr int kBoards = 6;
  const double board = std::floor(v * kBoards), across = v * kBoards - board;
  const auto seed = static_cast<std::uint32_t>(100 + board);
  const double shift = lattice(static_cast<std::int64_t>(board), 0, 7u);
  const double warp = fractal(u + shift, v, 3, 6, 3, seed);
  const double rings = 0.5 + 0.5 * std::sin(2.0 * std::numbers::pi * (9.0 * across + 5.0 * warp));
  const double fibre = fractal(u, v, 8, 256, 3, seed + 20u);
  const dvec3 light(0.52, 0.30, 0.14), dark(0.25, 0.115, 0.045);
  const dvec3 color = glm::mix(dark, light, 0.25 + 0.45 * rings + 0.3 * fibre) *
                      (0.75 + 0.5 * lattice(static_cast<std::int64_t>(board), 1, 7u));
  return color * (0.25 + 0.75 * step(0.0, 0.02, std::min(across, 1.0 - across)));
}

/// Blue bands, and between them a pattern of petals that repeats eight times around.
dvec3 porcelain(double u, double v) {
  const dvec3 white(0.80, 0.82, 0.84), blue(0.015, 0.04, 0.22);
  const double pi2 = 2.0 * std::numbers::pi;
  double ink = 0.0;
  for (const double band : {0.07, 0.11, 0.62, 0.88}) ink = std::max(ink, 1.0 - step(0.006, 0.011, std::abs(v - band)));
  const double a = std::fmod(8.0 * u, 1.0) - 0.5, h = (v - 0.365) / 0.2;
  const double radius = std::sqrt(4.0 * a * a + h * h), angle = std::atan2(h, 2.0 * a);
  const double petals = 0.55 + 0.3 * std::cos(5.0 * angle);
  ink = std::max(ink, (1.0 - step(petals - 0.03, petals + 0.03, radius)) * step(0.12, 0.17, radius) *
                          (0.55 + 0.45 * std::cos(20.0 * angle)));
  ink = std::max(ink, 1.0 - step(0.06, 0.09, radius));
  const double wave = 0.75 + 0.06 * std::sin(pi2 * 16.0 * u);
  ink = std::max(ink, 1.0 - step(0.008, 0.014, std::abs(v - wave)));
  return glm::mix(white, blue, ink * (0.7 + 0.3 * fractal(u, v, 64, 64, 2, 3u)));
}

/// Peel with dimples, and a dry spot where the stem was.
dvec3 orange(double u, double v) {
  const dvec3 peel(0.78, 0.26, 0.02), deep(0.55, 0.13, 0.005), stem(0.10, 0.13, 0.03);
  const double dimples = fractal(u, v, 96, 48, 2, 11u), blush = fractal(u, v, 4, 3, 3, 12u);
  const dvec3 color = glm::mix(deep, peel, std::clamp(0.35 + 0.8 * blush + 0.7 * (dimples - 0.5), 0.0, 1.0));
  return glm::mix(stem, color, step(0.012, 0.03, v + 0.006 * noise(12.0 * u, 0.0, 12, 1, 13u)));
}

/// Woven threads of two colours.
dvec3 cloth(double u, double v) {
  constexpr double kThreads = 96.0;
  const double x = u * kThreads, y = v * kThreads;
  const auto colored = [](double place) { return std::fmod(place, 1.0 / 4.0) < 1.0 / 8.0; };
  const bool over = std::fmod(std::floor(x) + std::floor(y), 2.0) == 0.0;
  const dvec3 red(0.45, 0.03, 0.03), cream(0.72, 0.66, 0.54);
  const double across = over ? x - std::floor(x) : y - std::floor(y);
  const double round = 1.0 - 1.6 * (across - 0.5) * (across - 0.5);
  return (colored(over ? u : v) ? red : cream) * (round * (0.85 + 0.15 * fractal(u, v, 128, 128, 2, 21u)));
}

using Painter = std::function<dvec3(double, double)>;
const std::map<std::string, Painter>& painters() {
  static const std::map<std::string, Painter> all = {
      {"cloth", cloth}, {"orange", orange}, {"porcelain", porcelain}, {"wood", wood}};
  return all;
}

}  // namespace

const std::vector<std::string>& picture_kinds() {
  static const std::vector<std::string> kinds = [] {
    std::vector<std::string> names;
    for (const auto& [name, painter] : painters()) names.push_back(name);
    return names;
  }();
  return kinds;
}

Image make_picture(const std::string& kind, std::uint32_t size) {
  const Painter& paint = painters().at(kind);
  Image image{.width = size, .height = size, .pixels = {}, .standard_error = {}, .sample_count = {}, .metadata = {}};
  image.pixels.reserve(std::size_t{size} * size);
  for (std::uint32_t row = 0; row < size; ++row) {
    for (std::uint32_t column = 0; column < size; ++column) {
      // v = 0 is at the bottom of all pictures but the orange; the first row is at the top.
      const double v = kind == "orange" ? (row + 0.5) / size : 1.0 - (row + 0.5) / size;
      image.pixels.emplace_back(glm::clamp(paint((column + 0.5) / size, v), dvec3(0.0), dvec3(1.0)));
    }
  }
  return image;
}

}  // namespace etendue::sculpt
