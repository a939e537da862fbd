#pragma once
/// Vectors and elementary functions with the same bits on every machine. They use only + − × ÷ and the square root,
/// which IEEE 754 rounds exactly, and no library functions, which may differ between implementations of libm.

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace etendue::sculpt {

struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;
};

inline Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(double s, Vec3 a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline Vec3 operator*(Vec3 a, Vec3 b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
inline Vec3 operator/(Vec3 a, Vec3 b) {
  return {a.x / b.x, a.y / b.y, a.z / b.z};
}
inline double dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Vec3 a) {
  return std::sqrt(dot(a, a));
}
inline Vec3 normalize(Vec3 a) {
  return (1.0 / length(a)) * a;
}

inline double clamp01(double x) {
  return std::clamp(x, 0.0, 1.0);
}
inline double mix(double a, double b, double t) {
  return a + t * (b - a);
}
/// 0 below `a`, 1 above `b`, and a cubic in between.
inline double smoothstep(double a, double b, double x) {
  const double t = clamp01((x - a) / (b - a));
  return t * t * (3.0 - 2.0 * t);
}

/// sin(2π x) with an absolute error below 2e-4, which is enough for ornaments: a parabola with one correction.
inline double sin_turns(double x) {
  const double t = 2.0 * (x - std::floor(x)) - 1.0;  // half turns from π, in [-1, 1)
  const double y = -4.0 * t * (1.0 - std::abs(t));
  return 0.775 * y + 0.225 * y * std::abs(y);
}
inline double cos_turns(double x) {
  return sin_turns(x + 0.25);
}

/// A well-mixed 32-bit word for a lattice point, with integer arithmetic only [Jarzynski2020, pcg3d].
inline std::uint32_t hash(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  x = x * 1664525u + 1013904223u;
  y = y * 1664525u + 1013904223u;
  z = z * 1664525u + 1013904223u;
  x += y * z;
  y += z * x;
  z += x * y;
  x ^= x >> 16;
  y ^= y >> 16;
  z ^= z >> 16;
  return x + y * z;
}
/// Maps the word to a number in [-1, 1).
inline double signed_unit(std::uint32_t word) {
  return static_cast<double>(word >> 8) * (1.0 / (1 << 23)) - 1.0;
}

}  // namespace etendue::sculpt
