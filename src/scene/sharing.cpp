#include "scene/sharing.h"

#include <algorithm>
#include <cmath>

namespace etendue {

double transform_condition(const glm::dmat4& world_from_object) {
  const glm::dmat3 m(world_from_object), inverse = glm::inverse(m);
  double largest = 0.0;
  for (int k = 0; k < 3; ++k) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) sum += std::abs(m[i][k]) * std::abs(inverse[j][i]);
    }
    if (!(sum <= largest)) largest = sum;  // also what is not a number
  }
  return largest;
}

namespace {

double largest_entry(const glm::dmat3& m) {
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) largest = std::max({largest, std::abs(m[i].x), std::abs(m[i].y), std::abs(m[i].z)});
  return largest;
}

/// Whether rays can be carried into object space and back.
bool is_carried(const glm::dmat4& world_from_object) {
  const glm::dmat3 m(world_from_object);
  const double ratio = largest_entry(m) * largest_entry(glm::inverse(m));
  return transform_condition(world_from_object) <= kMostCondition && ratio <= kMostRatio;
}

}  // namespace

Sharing::Sharing(const Scene& scene) {
  if (scene.instancing == Instancing::never) return;
  const bool always = scene.instancing == Instancing::always;
  std::size_t primitives = 0;
  std::vector<std::size_t> uses(scene.shapes.size(), 0);
  for (const Instance& instance : scene.instances) {
    primitives += primitive_count(scene.shape_of(instance));
    ++uses[instance.shape];
  }
  if (!always && primitives <= kFlattenAtMost) return;
  shapes_.assign(scene.shapes.size(), false);
  instances_.assign(scene.instances.size(), false);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const auto* mesh = std::get_if<TriangleMesh>(&scene.shape_of(instance));
    if (mesh == nullptr || mesh->triangles.size() < (always ? 1 : kLeastShared)) continue;
    if (!always && uses[instance.shape] < 2) continue;
    if (!is_carried(instance.world_from_object)) continue;
    any_ = shapes_[instance.shape] = instances_[i] = true;
  }
}

}  // namespace etendue
