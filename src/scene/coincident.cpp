#include "scene/coincident.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
#include "scene/bounds.h"
#include "scene/placed.h"
#include "scene/sharing.h"

namespace etendue {
namespace {

constexpr std::size_t kMaxPairs = std::size_t{1} << 22;
/// Planes are distinguished in steps of the normal and of the scene's size. The steps are odd, so that common values
/// such as 0 and 1 do not lie between two of them.
constexpr double kNormalStep = 3.1e-5;
constexpr double kOffsetStep = 2.7e-7;

/// More than so many instances are not compared box by box.
constexpr std::size_t kManyInstances = 2000;

/// The location of a triangle: its plane in steps, whichever way it faces, and its interval along an axis of that
/// plane.
struct Face {
  std::array<std::int64_t, 4> plane{};
  double lower = 0.0, upper = 0.0;
  std::uint32_t instance = 0, triangle = 0;
};

bool meet(const Bounds& a, const Bounds& b, double margin) {
  return glm::all(glm::lessThanEqual(a.min, b.max + margin)) && glm::all(glm::lessThanEqual(b.min, a.max + margin));
}

class Finder {
 public:
  Finder(const Scene& scene, Diagnostics& sink) : scene_(scene), sharing_(scene), sink_(sink) {}

  void find() {
    measure();
    for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) add_faces(i);
    std::sort(faces_.begin(), faces_.end(), [](const Face& a, const Face& b) {
      return std::tie(a.plane, a.lower, a.instance, a.triangle) < std::tie(b.plane, b.lower, b.instance, b.triangle);
    });
    for (std::size_t i = 0; i < faces_.size() && pairs_ < kMaxPairs; ++i) {
      for (std::size_t j = i + 1; j < faces_.size() && pairs_ < kMaxPairs; ++j) {
        if (faces_[j].plane != faces_[i].plane || !(faces_[j].lower < faces_[i].upper)) break;
        ++pairs_;
        compare(faces_[i], faces_[j]);
      }
    }
    find_spheres();
  }

 private:
  /// The boxes of all meshes, and the largest coordinate, which offsets of planes are measured by.
  void measure() {
    for (std::size_t n = 0; n < scene_.instances.size(); ++n) {
      const Instance& instance = scene_.instances[n];
      const bool looked_at =
          std::holds_alternative<TriangleMesh>(scene_.shape_of(instance)) && !sharing_.has_instance(n);
      const Bounds& box = boxes_.emplace_back(looked_at ? bounds_of(scene_, instance) : Bounds{});
      if (box.empty()) continue;
      const glm::dvec3 farthest = glm::max(glm::abs(box.min), glm::abs(box.max));
      size_ = std::max({size_, farthest.x, farthest.y, farthest.z});
    }
  }

  /// The boxes of other meshes that meet that of this one.
  std::vector<Bounds> neighbours(std::uint32_t index) const {
    std::vector<Bounds> found;
    for (std::uint32_t i = 0; i < boxes_.size(); ++i) {
      if (i != index && meet(boxes_[i], boxes_[index], size_ * kOffsetStep)) found.push_back(boxes_[i]);
    }
    return found;
  }

  void add_faces(std::uint32_t index) {
    const Instance& instance = scene_.instances[index];
    const auto* mesh = std::get_if<TriangleMesh>(&scene_.shape_of(instance));
    if (mesh == nullptr || sharing_.has_instance(index)) return;
    // Most meshes meet few others, and of a large one few triangles can lie in one of theirs.
    const bool many = boxes_.size() > kManyInstances;
    const std::vector<Bounds> others = many ? std::vector<Bounds>() : neighbours(index);
    if (!many && others.empty()) return;
    const PlacedMesh placed(*mesh, instance);
    for (std::size_t t = 0; t < placed.triangle_count(); ++t) {
      const auto [a, b, c] = placed.triangle(t);
      Bounds box;
      for (const glm::dvec3& p : {a, b, c}) box.add(p);
      const auto meets = [&](const Bounds& other) { return meet(other, box, size_ * kOffsetStep); };
      if (!many && std::none_of(others.begin(), others.end(), meets)) continue;
      glm::dvec3 n = glm::cross(b - a, c - a);
      const double length = glm::length(n);
      if (!(length > 0.0)) continue;
      n /= length;
      // Both faces of a plane get the same name: the first component that counts is positive.
      const double sign = std::abs(n.x) > 0.5 ? n.x : std::abs(n.y) > 0.5 ? n.y : n.z;
      if (sign < 0.0) n = -n;
      Face face{.instance = index, .triangle = static_cast<std::uint32_t>(t)};
      for (int k = 0; k < 3; ++k) face.plane[static_cast<std::size_t>(k)] = std::llround(n[k] / kNormalStep);
      face.plane[3] = std::llround(glm::dot(n, a) / (size_ * kOffsetStep));
      const int axis = std::abs(n.x) > 0.5 ? 1 : 0;  // not along the normal
      face.lower = std::min({a[axis], b[axis], c[axis]});
      face.upper = std::max({a[axis], b[axis], c[axis]});
      faces_.push_back(face);
    }
  }

  std::array<glm::dvec3, 3> corners(const Face& face) const {
    const Instance& instance = scene_.instances[face.instance];
    return PlacedMesh(std::get<TriangleMesh>(scene_.shape_of(instance)), instance).triangle(face.triangle);
  }

  void compare(const Face& a, const Face& b) {
    if (a.instance == b.instance) return;
    const std::pair<std::uint32_t, std::uint32_t> pair = std::minmax(a.instance, b.instance);
    if (reported_.contains(pair)) return;
    const std::array<glm::dvec3, 3> p = corners(a), q = corners(b);
    const glm::dvec3 np = glm::cross(p[1] - p[0], p[2] - p[0]), nq = glm::cross(q[1] - q[0], q[2] - q[0]);
    if (!(glm::dot(np, nq) > 0.0) && !is_glass(a.instance) && !is_glass(b.instance)) return;
    if (overlap(p, q, np) && overlap(q, p, np)) report(pair);
  }

  bool is_glass(std::uint32_t instance) const {
    return std::holds_alternative<DielectricBsdf>(scene_.bsdf_of(scene_.instances[instance]));
  }

  /// False where an edge of `p` separates it from `q`, both in a plane of normal `n`, or leaves a sliver in common.
  static bool overlap(const std::array<glm::dvec3, 3>& p, const std::array<glm::dvec3, 3>& q, const glm::dvec3& n) {
    constexpr double kSliver = 1e-6;  // of the edge's distance to the opposite corner
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 across = glm::cross(n, p[(i + 1) % 3] - p[i]);
      const double inner = glm::dot(across, p[(i + 2) % 3] - p[i]);
      double farthest = -std::numeric_limits<double>::infinity();
      for (const glm::dvec3& corner : q) farthest = std::max(farthest, glm::dot(across, corner - p[i]) / inner);
      if (farthest < kSliver) return false;
    }
    return true;
  }

  void find_spheres() {
    std::vector<std::tuple<double, double, double, double, std::uint32_t>> spheres;
    for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
      const Instance& instance = scene_.instances[i];
      if (const auto* object = std::get_if<Sphere>(&scene_.shape_of(instance))) {
        const Sphere s = placed_sphere(*object, instance);
        spheres.emplace_back(s.center.x, s.center.y, s.center.z, s.radius, i);
      }
    }
    std::sort(spheres.begin(), spheres.end());
    for (std::size_t i = 1; i < spheres.size(); ++i) {
      const auto& [x, y, z, r, a] = spheres[i - 1];
      const auto& [x2, y2, z2, r2, b] = spheres[i];
      if (std::tie(x, y, z, r) == std::tie(x2, y2, z2, r2)) report(std::minmax(a, b));
    }
  }

  void report(const std::pair<std::uint32_t, std::uint32_t>& pair) {
    constexpr std::size_t kMaxReports = 20;
    if (reported_.size() >= kMaxReports || !reported_.insert(pair).second) return;
    const Instance &first = scene_.instances[pair.first], &second = scene_.instances[pair.second];
    sink_.warning(second.position,
                  fmt::format("{} coincides with a surface of {} of line {}: where both are at the same distance the "
                              "first in the file is visible, elsewhere rounding decides; move them apart",
                              text::quoted(second.name), text::quoted(first.name), first.position.line));
  }

  const Scene& scene_;
  Sharing sharing_;
  Diagnostics& sink_;
  double size_ = 1e-300;
  std::vector<Bounds> boxes_;  ///< of the instances; empty boxes for what is no mesh
  std::vector<Face> faces_;
  std::size_t pairs_ = 0;
  std::set<std::pair<std::uint32_t, std::uint32_t>> reported_;
};

}  // namespace

void check_coincident(const Scene& scene, Diagnostics& diagnostics) {
  if (scene.instances.size() > 1) Finder(scene, diagnostics).find();
}

void check_coincident(const SceneFile& file, Diagnostics& diagnostics) {
  if (const auto* scene = std::get_if<Scene>(&file)) check_coincident(*scene, diagnostics);
  if (const auto* test = std::get_if<TTest>(&file)) {
    for (const Scene& scene : test->scenes) check_coincident(scene, diagnostics);
  }
}

}  // namespace etendue
