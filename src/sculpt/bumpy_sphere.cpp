#include <array>

#include "sculpt/field.h"

namespace etendue::sculpt {

double noise(Vec3 p) {
  const Vec3 cell{std::floor(p.x), std::floor(p.y), std::floor(p.z)};
  const Vec3 f = p - cell;
  const auto fade = [](double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); };
  const auto word = [](double x) { return static_cast<std::uint32_t>(static_cast<std::int64_t>(x)); };
  const auto at = [&](double i, double j,
                      double k) {  // the plane through a lattice point, with its slope, evaluated at p
    const std::uint32_t h = hash(word(cell.x + i), word(cell.y + j), word(cell.z + k));
    const Vec3 slope{signed_unit(h), signed_unit(h * 0x9e3779b9u), signed_unit(h * 0x85ebca6bu)};
    return dot(slope, f - Vec3{i, j, k});
  };
  const double u = fade(f.x), v = fade(f.y), w = fade(f.z);
  const auto row = [&](double j, double k) { return mix(at(0, j, k), at(1, j, k), u); };
  return mix(mix(row(0, 0), row(1, 0), v), mix(row(0, 1), row(1, 1), v), w);
}

namespace {

// Three octaves, hills, bumps and fine grain, so that neighbouring rays meet different slopes. The lattices are rotated
// relative to each other, so that none of them is visible.
double value(Vec3 p) {
  const double r = length(p);
  if (r > 0.75 || r < 0.25) return r - 0.5;
  const Vec3 q{0.48 * p.x + 0.36 * p.y + 0.8 * p.z, -0.8 * p.x + 0.6 * p.y, -0.36 * p.x - 0.6 * p.y + 0.72 * p.z};
  const Vec3 s{0.8 * q.x + 0.6 * q.z, q.y, -0.6 * q.x + 0.8 * q.z};
  return r - 0.5 - 0.095 * noise(4.0 * p) - 0.040 * noise(11.0 * q) - 0.011 * noise(31.0 * s);
}

}  // namespace

Solid bumpy_sphere() {
  return {value, {-0.62, -0.62, -0.62}, {0.62, 0.62, 0.62}, 2.5};
}

}  // namespace etendue::sculpt
