#include "sculpt/turned.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace etendue::sculpt {
namespace {

/// A point of an outline; its position along the outline is in [0,1].
struct Outline {
  double radius = 0.0;
  double height = 0.0;
};

/// A cubic through the middle two of four values (Catmull-Rom).
double between(double a, double b, double c, double d, double t) {
  return b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)));
}

Outline along(const std::vector<Outline>& knots, double place) {
  const double at = place * static_cast<double>(knots.size() - 1);
  const auto last = static_cast<std::ptrdiff_t>(knots.size()) - 1;
  const auto i = std::min(static_cast<std::ptrdiff_t>(at), last - 1);
  const auto knot = [&](std::ptrdiff_t k) {
    return knots[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(k, 0, last))];
  };
  const double t = at - static_cast<double>(i);
  const Outline a = knot(i - 1), b = knot(i), c = knot(i + 1), d = knot(i + 2);
  return {between(a.radius, b.radius, c.radius, d.radius, t), between(a.height, b.height, c.height, d.height, t)};
}

/// Rotates the outline about the y axis. v grows along it from 0 at the foot to 1 at the rim, and further.
Mesh turn(const std::vector<Outline>& knots, double rim, std::uint64_t triangles) {
  const auto around = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(triangles) * 0.75)));
  const auto up = static_cast<std::uint32_t>(std::ceil(static_cast<double>(triangles) / (2.0 * around)));
  Mesh mesh;
  std::vector<bool> on_axis;  // rows whose corners are all the same point
  for (std::uint32_t j = 0; j <= up; ++j) {
    const double place = static_cast<double>(j) / up;
    const Outline p = along(knots, place);
    on_axis.push_back(p.radius < 1e-9);
    constexpr double kStep = 1e-5;
    const Outline before = along(knots, std::max(0.0, place - kStep)),
                  after = along(knots, std::min(1.0, place + kStep));
    double out = after.height - before.height, rise = before.radius - after.radius;
    const double length = std::sqrt(out * out + rise * rise);
    out /= length, rise /= length;
    for (std::uint32_t i = 0; i <= around; ++i) {  // corners at the seam exist twice, with u = 0 and u = 1
      const double u = static_cast<double>(i) / around, angle = 2.0 * std::numbers::pi * (i == around ? 0.0 : u);
      const double c = std::cos(angle), s = std::sin(angle);
      mesh.positions.push_back({p.radius * c, p.height, -p.radius * s});
      mesh.normals.push_back({out * c, rise, -out * s});
      mesh.uvs.push_back({u, place / rim});
    }
  }
  for (std::uint32_t j = 0; j < up; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t a = j * (around + 1) + i, b = a + around + 1;
      if (!on_axis[j]) mesh.triangles.push_back({a, a + 1, b + 1});
      if (!on_axis[j + 1]) mesh.triangles.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

}  // namespace

Mesh vase(std::uint64_t triangles) {
  return turn({{0.13, 0.0},
               {0.17, 0.03},
               {0.26, 0.2},
               {0.30, 0.42},
               {0.24, 0.66},
               {0.13, 0.82},
               {0.11, 0.90},
               {0.16, 0.99},
               {0.17, 1.0},
               {0.15, 0.99},
               {0.10, 0.90},
               {0.11, 0.82},
               {0.22, 0.66},
               {0.28, 0.42},
               {0.24, 0.2},
               {0.02, 0.05}},
              8.0 / 15.0, triangles);
}

Mesh bowl(std::uint64_t triangles) {
  return turn({{0.20, 0.0},
               {0.21, 0.03},
               {0.36, 0.10},
               {0.46, 0.20},
               {0.5, 0.31},
               {0.49, 0.32},
               {0.48, 0.31},
               {0.44, 0.21},
               {0.34, 0.12},
               {0.18, 0.06},
               {0.01, 0.05}},
              5.0 / 10.0, triangles);
}

Mesh goblet(std::uint64_t triangles) {
  return turn(
      {{0.0, 0.0},     {0.14, 0.0},   {0.215, 0.004}, {0.222, 0.014}, {0.15, 0.028}, {0.045, 0.055}, {0.022, 0.12},
       {0.019, 0.28},  {0.024, 0.41}, {0.09, 0.49},   {0.205, 0.62},  {0.24, 0.77},  {0.215, 0.92},  {0.197, 0.994},
       {0.189, 0.994}, {0.205, 0.92}, {0.228, 0.77},  {0.193, 0.63},  {0.08, 0.51},  {0.0, 0.475}},
      1.0, triangles);
}

Mesh curtain(std::uint64_t triangles) {
  const auto up = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(triangles) / 8.0)));
  const std::uint32_t across = 4 * up;
  constexpr double kPi = std::numbers::pi;
  // Depth of the seven uneven folds, which are narrow at the rail and wider toward the hem.
  const auto depth = [&](double u, double v) {
    const double phase = 14.0 * kPi * (u + 0.012 * std::sin(5.0 * kPi * u + 1.5 * v) + 0.02 * std::sin(3.0 * u + v));
    return (0.022 + 0.02 * (1.0 - v)) * (std::sin(phase) + 0.25 * std::sin(2.0 * phase + 1.0 + v)) +
           0.012 * std::sin(2.0 * kPi * u + 2.0 * v);
  };
  Mesh mesh;
  for (std::uint32_t j = 0; j <= up; ++j) {
    for (std::uint32_t i = 0; i <= across; ++i) {
      const double u = static_cast<double>(i) / across, v = static_cast<double>(j) / up;
      constexpr double kStep = 1e-4;
      const double slope_x = (depth(u + kStep, v) - depth(u - kStep, v)) / (2.0 * kStep);
      const double slope_y = (depth(u, v + kStep) - depth(u, v - kStep)) / (2.0 * kStep);
      mesh.positions.push_back({u - 0.5, v, depth(u, v)});
      mesh.normals.push_back(normalize(Vec3{-slope_x, -slope_y, 1.0}));
      mesh.uvs.push_back({u, v});
    }
  }
  for (std::uint32_t j = 0; j < up; ++j) {
    for (std::uint32_t i = 0; i < across; ++i) {
      const std::uint32_t a = j * (across + 1) + i, b = a + across + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
  return mesh;
}

Mesh tile() {
  Mesh mesh;
  mesh.positions = {{-0.5, 0.0, 0.5}, {0.5, 0.0, 0.5}, {0.5, 0.0, -0.5}, {-0.5, 0.0, -0.5}};
  mesh.uvs = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

}  // namespace etendue::sculpt
