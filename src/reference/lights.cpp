#include "reference/lights.h"

#include <algorithm>
#include <cmath>

#include "reference/intersect.h"

namespace etendue::reference {

DiscreteChoice::DiscreteChoice(const std::vector<double>& weights) {
  double sum = 0.0;
  for (const double weight : weights) sum += weight;
  if (!(sum > 0.0)) return;
  const std::size_t n = weights.size();
  thresholds_.assign(n + 1, 0);
  double prefix = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    prefix += weights[i];
    thresholds_[i + 1] = static_cast<std::uint64_t>(std::floor(0x1p32 * prefix / sum));
  }
  // Whatever has weight must have a chance: at least one unit each, upward, then downward to end at 2^32 again.
  for (std::size_t i = 0; i < n; ++i)
    thresholds_[i + 1] = std::max(thresholds_[i + 1], thresholds_[i] + (weights[i] > 0.0 ? 1 : 0));
  thresholds_[n] = std::uint64_t{1} << 32;
  for (std::size_t i = n; i-- > 0;)
    thresholds_[i] = std::min(thresholds_[i], thresholds_[i + 1] - (weights[i] > 0.0 ? 1 : 0));
}

std::size_t DiscreteChoice::choose(std::uint32_t word) const {
  const auto above = std::upper_bound(thresholds_.begin(), thresholds_.end(), std::uint64_t{word});
  return static_cast<std::size_t>(above - thresholds_.begin()) - 1;
}

double DiscreteChoice::prob(std::size_t index) const {
  return empty() ? 0.0 : static_cast<double>(thresholds_[index + 1] - thresholds_[index]) * 0x1p-32;
}

namespace {

AreaLight make_light(const Scene& scene, std::uint32_t index) {
  const Instance& instance = scene.instances[index];
  AreaLight light{.instance = index,
                  .placement = Placement(instance),
                  .radiance = scene.emitter_of(instance)->radiance,
                  .area = 0.0,
                  .triangles = {}};
  if (const auto* object = std::get_if<Sphere>(&scene.shape_of(instance))) {
    const Sphere sphere = light.placement.sphere(*object);
    light.area = 4.0 * kPi * sphere.radius * sphere.radius;
    return light;
  }
  const auto& mesh = std::get<TriangleMesh>(scene.shape_of(instance));
  std::vector<double> areas;
  areas.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [p0, p1, p2] = light.placement.triangle(mesh, i);
    areas.push_back(triangle_area(p0, p1, p2));
    light.area += areas.back();
  }
  light.triangles = DiscreteChoice(areas);
  return light;
}

/// The side of a triangle's light is that of its vertex normals: the leaf's normal is their mean, or none where one of
/// them points away from it.
void shine_by_vertex_normals(const TriangleMesh& mesh, std::uint32_t i, const Placement& placement, LightLeaf& leaf) {
  const glm::uvec3 t = mesh.triangles[i];
  Vec3 sum(0.0);
  for (int k = 0; k < 3; ++k) {
    leaf.corner_normals.push_back(placement.normal(mesh.normals[t[k]]));
    sum += leaf.corner_normals.back();
  }
  leaf.normal = sum == Vec3(0.0) ? sum : glm::normalize(sum);
  const bool apart = std::any_of(leaf.corner_normals.begin(), leaf.corner_normals.end(),
                                 [&](const Vec3& n) { return !(glm::dot(n, leaf.normal) > 0.0); });
  if (apart) leaf.normal = Vec3(0.0);
}

/// Every primitive that emits, in the order of the scene.
std::vector<LightLeaf> light_leaves(const Scene& scene, const std::vector<AreaLight>& lights) {
  std::vector<LightLeaf> leaves;
  for (std::uint32_t l = 0; l < lights.size(); ++l) {
    const double radiance = luminance(lights[l].radiance);
    const Shape& shape = scene.shape_of(scene.instances[lights[l].instance]);
    if (!(radiance > 0.0)) continue;
    if (const auto* object = std::get_if<Sphere>(&shape)) {
      const Sphere sphere = lights[l].placement.sphere(*object);
      leaves.push_back({.light = l,
                        .primitive = 0,
                        .power = radiance * kPi * sphere.radius * sphere.radius,
                        .lower = sphere.center - sphere.radius,
                        .upper = sphere.center + sphere.radius});
      continue;
    }
    const auto& mesh = std::get<TriangleMesh>(shape);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [p0, p1, p2] = lights[l].placement.triangle(mesh, i);
      if (is_degenerate(p0, p1, p2)) continue;
      leaves.push_back({.light = l,
                        .primitive = i,
                        .power = radiance * triangle_area(p0, p1, p2),
                        .lower = glm::min(p0, glm::min(p1, p2)),
                        .upper = glm::max(p0, glm::max(p1, p2)),
                        .normal = glm::normalize(glm::cross(p1 - p0, p2 - p0))});
      if (!mesh.normals.empty()) shine_by_vertex_normals(mesh, i, lights[l].placement, leaves.back());
    }
  }
  return leaves;
}

}  // namespace

double Lights::prob(const Vec3& from, const Vec3& ns, std::uint32_t instance, std::uint32_t primitive) const {
  const std::optional<std::size_t> index = of_instance_[instance];
  if (!index) return 0.0;
  if (!tree_.empty()) return tree_.prob(from, ns, static_cast<std::uint32_t>(*index), primitive);
  const DiscreteChoice& triangles = lights_[*index].triangles;
  return choice_.prob(*index) * (triangles.empty() ? 1.0 : triangles.prob(primitive));
}

Lights::Lights(const Scene& scene) : of_instance_(scene.instances.size()) {
  std::vector<double> weights;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
    if (!scene.instances[i].emitter) continue;
    of_instance_[i] = lights_.size();
    lights_.push_back(make_light(scene, i));
    weights.push_back(luminance(lights_.back().radiance) * lights_.back().area);
  }
  choice_ = DiscreteChoice(weights);
  if (wants_light_tree(scene)) tree_ = LightTree(light_leaves(scene, lights_));
}

}  // namespace etendue::reference
