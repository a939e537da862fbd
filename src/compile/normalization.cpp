#include "compile/normalization.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "scene/bounds.h"
#include "scene/placed.h"
#include "scene/sharing.h"

namespace etendue {
namespace {

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Calls visit(lower corner, upper corner, centroid) for every primitive.
// An instance of a shared mesh counts as one primitive, by the box around its transformed box.
template <typename Visit>
void for_each_primitive(const Scene& scene, const Visit& visit) {
  const Sharing sharing(scene);
  std::vector<Bounds> boxes(sharing.any() ? scene.shapes.size() : 0);
  for (std::size_t s = 0; s < boxes.size(); ++s) {
    if (sharing.has_shape(s)) boxes[s] = bounds_of(scene.shapes[s]);
  }
  for (std::size_t n = 0; n < scene.instances.size(); ++n) {
    const Instance& instance = scene.instances[n];
    const Shape& shape = scene.shape_of(instance);
    if (sharing.has_instance(n)) {
      const Bounds box = transformed(boxes[instance.shape], instance.world_from_object);
      visit(box.min, box.max, 0.5 * box.min + 0.5 * box.max);
      continue;
    }
    if (const auto* local = std::get_if<Sphere>(&shape)) {
      const Sphere sphere = placed_sphere(*local, instance);
      visit(sphere.center - sphere.radius, sphere.center + sphere.radius, sphere.center);
      continue;
    }
    if (!std::holds_alternative<TriangleMesh>(shape)) {
      const Bounds box = bounds_of(scene, instance);
      visit(box.min, box.max, 0.5 * box.min + 0.5 * box.max);
      continue;
    }
    const PlacedMesh mesh(std::get<TriangleMesh>(shape), instance);
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
      const auto [a, b, c] = mesh.triangle(i);
      visit(glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c)), (a + b + c) / 3.0);
    }
  }
}

}  // namespace

Normalization find_normalization(const Scene& scene) {
  std::vector<double> centroids[3];
  glm::dvec3 lower(INFINITY), upper(-INFINITY);
  for_each_primitive(scene, [&](const glm::dvec3& lo, const glm::dvec3& hi, const glm::dvec3& centroid) {
    lower = glm::min(lower, lo);
    upper = glm::max(upper, hi);
    for (int a = 0; a < 3; ++a) centroids[a].push_back(centroid[a]);
  });
  Normalization n;
  if (centroids[0].empty()) return n;
  for (int a = 0; a < 3; ++a) n.center[a] = median(centroids[a]);
  const glm::dvec3 reach = glm::max(upper - n.center, n.center - lower);
  const double farthest = std::max({reach.x, reach.y, reach.z});
  constexpr double kLargestExponent = 1000.0;  // a scene of one denormal sphere must not be scaled by infinity
  if (farthest > 0.0) n.scale = std::exp2(std::min(-std::ceil(std::log2(farthest)), kLargestExponent));
  return n;
}

}  // namespace etendue
