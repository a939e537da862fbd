#include "formats/mesh/polygon.h"

#include <algorithm>
#include <cmath>

namespace etendue {
namespace {

/// Twice the signed area of (a, b, c).
double cross2(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// The polygon seen against its area vector (Newell), counter-clockwise. Coordinates are relative to corner 0 and
/// divided by the extent, so that polygons far from the origin keep their digits and products neither overflow nor
/// vanish.
std::vector<glm::dvec2> project(std::span<const glm::dvec3> polygon) {
  double extent = 0.0;
  for (const glm::dvec3& p : polygon) {
    const glm::dvec3 d = glm::abs(p - polygon[0]);
    extent = std::max({extent, d.x, d.y, d.z});
  }
  const double scale = extent > 0.0 ? 1.0 / extent : 1.0;
  std::vector<glm::dvec3> local;
  local.reserve(polygon.size());
  for (const glm::dvec3& p : polygon) local.push_back((p - polygon[0]) * scale);
  glm::dvec3 area(0.0);
  for (std::size_t i = 0; i < local.size(); ++i) area += glm::cross(local[i], local[(i + 1) % local.size()]);
  const glm::dvec3 size = glm::abs(area);
  const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  const bool flip = area[axis] < 0.0;
  std::vector<glm::dvec2> flat;
  flat.reserve(local.size());
  for (const glm::dvec3& p : local) {
    const glm::dvec2 q(p[(axis + 1) % 3], p[(axis + 2) % 3]);
    flat.push_back(flip ? glm::dvec2(q.y, q.x) : q);
  }
  return flat;
}

/// Turns left everywhere and goes around once (a star polygon turns left too, but several times around).
bool is_convex(const std::vector<glm::dvec2>& p) {
  const std::size_t n = p.size();
  int sign_changes = 0;
  double previous = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (cross2(p[i], p[(i + 1) % n], p[(i + 2) % n]) < 0.0) return false;
    const double dx = p[(i + 1) % n].x - p[i].x;
    if (dx == 0.0) continue;
    if (previous != 0.0 && (dx > 0.0) != (previous > 0.0)) ++sign_changes;
    previous = dx;
  }
  return sign_changes <= 2;
}

class EarClipper {
 public:
  EarClipper(const std::vector<glm::dvec2>& points, std::int64_t& work) : points_(points), work_(work) {
    const auto n = static_cast<std::uint32_t>(points.size());
    next_.resize(n);
    previous_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      next_[i] = (i + 1) % n;
      previous_[i] = (i + n - 1) % n;
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      if (turn(i) < 0.0) reflex_.push_back(i);
    }
  }

  bool clip(std::vector<PolygonTriangle>& triangles) {
    bool clean = true;
    auto remaining = static_cast<std::uint32_t>(points_.size());
    std::uint32_t at = 0, refused = 0;
    while (remaining > 3) {
      const bool give_up = refused == remaining || work_ <= 0;
      if (!give_up && !is_ear(at)) {
        at = next_[at];
        ++refused;
        continue;
      }
      // No ear is left in a polygon that crosses itself: cutting any corner still covers it, and the end is certain.
      clean = clean && !give_up;
      triangles.emplace_back(previous_[at], at, next_[at]);
      at = remove(at);
      --remaining;
      refused = 0;
    }
    triangles.emplace_back(previous_[at], at, next_[at]);
    return clean;
  }

 private:
  double turn(std::uint32_t i) const { return cross2(points_[previous_[i]], points_[i], points_[next_[i]]); }

  /// Convex, with no reflex corner inside: only those can be in the way. A corner that coincides with one of the ear's
  /// (the bridge of a polygon with a hole) is not.
  bool is_ear(std::uint32_t i) {
    const double area = turn(i);
    if (area < 0.0) return false;
    const glm::dvec2 &a = points_[previous_[i]], &b = points_[i], &c = points_[next_[i]];
    if (area == 0.0) return true;  // collinear: a triangle without area hides nothing
    work_ -= static_cast<std::int64_t>(reflex_.size());
    for (const std::uint32_t r : reflex_) {
      const glm::dvec2& q = points_[r];
      if (q == a || q == b || q == c) continue;
      if (cross2(a, b, q) >= 0.0 && cross2(b, c, q) >= 0.0 && cross2(c, a, q) >= 0.0) return false;
    }
    return true;
  }

  /// Cuts corner `i` off and returns where to go on: two corners further, which avoids fans of slivers.
  std::uint32_t remove(std::uint32_t i) {
    const std::uint32_t before = previous_[i], after = next_[i];
    next_[before] = after;
    previous_[after] = before;
    std::erase_if(reflex_, [&](std::uint32_t r) { return r == i || ((r == before || r == after) && turn(r) >= 0.0); });
    work_ -= static_cast<std::int64_t>(reflex_.size());
    return next_[after];
  }

  const std::vector<glm::dvec2>& points_;
  std::int64_t& work_;
  std::vector<std::uint32_t> next_, previous_, reflex_;
};

}  // namespace

bool triangulate(std::span<const glm::dvec3> polygon, std::vector<PolygonTriangle>& triangles, std::int64_t& work) {
  const auto n = static_cast<std::uint32_t>(polygon.size());
  if (n == 3) {
    triangles.emplace_back(0, 1, 2);
    return true;
  }
  const std::vector<glm::dvec2> points = project(polygon);
  if (is_convex(points)) {
    for (std::uint32_t i = 2; i < n; ++i) triangles.emplace_back(0, i - 1, i);
    return true;
  }
  return EarClipper(points, work).clip(triangles);
}

}  // namespace etendue
