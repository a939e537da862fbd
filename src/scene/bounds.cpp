#include "scene/bounds.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "scene/placed.h"

namespace etendue {

Bounds bounds_of(const Shape& shape) {
  Bounds box;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) {
    box.add(sphere->center - sphere->radius);
    box.add(sphere->center + sphere->radius);
  } else if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) {
    for (const glm::dvec3& p : mesh->positions) box.add(p);
  } else {
    throw std::logic_error("only meshes are shared; others have a box where an instance puts them");
  }
  return box;
}

Bounds transformed(const Bounds& box, const glm::dmat4& world_from_object) {
  if (box.empty()) return box;
  const glm::dvec3 center(world_from_object * glm::dvec4(0.5 * box.min + 0.5 * box.max, 1.0));
  const glm::dvec3 half = 0.5 * box.max - 0.5 * box.min;
  glm::dvec3 reach(0.0);
  for (int i = 0; i < 3; ++i) reach += glm::abs(glm::dvec3(world_from_object[i])) * half[i];
  Bounds out;
  out.add(center - reach);
  out.add(center + reach);
  return out;
}

Bounds bounds_of(const Scene& scene, const Instance& instance) {
  Bounds box;
  const Shape& shape = scene.shape_of(instance);
  if (const auto* object = std::get_if<Sphere>(&shape)) {
    const Sphere sphere = placed_sphere(*object, instance);
    box.add(sphere.center - sphere.radius);
    box.add(sphere.center + sphere.radius);
  } else if (std::holds_alternative<Disk>(shape)) {
    const PlacedDisk disk = placed_disk(instance);
    box.add(disk.center - disk.reach());
    box.add(disk.center + disk.reach());
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    const PlacedCylinder placed = placed_cylinder(*cylinder, instance);
    for (const glm::dvec3& end : {placed.p0, placed.p1}) {
      box.add(end - placed.reach());
      box.add(end + placed.reach());
    }
  } else {
    const PlacedMesh mesh(std::get<TriangleMesh>(shape), instance);
    for (std::uint32_t i = 0; i < mesh.mesh().positions.size(); ++i) box.add(mesh.position(i));
  }
  return box;
}

std::vector<Bounds> instance_bounds(const Scene& scene, const Sharing& sharing) {
  std::vector<Bounds> objects(scene.shapes.size());
  for (std::size_t s = 0; s < objects.size(); ++s) {
    if (sharing.has_shape(s)) objects[s] = bounds_of(scene.shapes[s]);
  }
  std::vector<Bounds> boxes;
  boxes.reserve(scene.instances.size());
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    boxes.push_back(sharing.has_instance(i) ? transformed(objects[instance.shape], instance.world_from_object)
                                            : bounds_of(scene, instance));
  }
  return boxes;
}

Bounds bounds_of(const Scene& scene) {
  Bounds all;
  for (const Bounds& box : instance_bounds(scene, Sharing(scene))) {
    if (box.empty()) continue;
    all.add(box.min);
    all.add(box.max);
  }
  return all;
}

double typical_radius(const Scene& scene) {
  const auto lower_median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  std::vector<glm::dvec3> middles;
  std::vector<double> radii;
  for (const Bounds& box : instance_bounds(scene, Sharing(scene))) {
    if (box.empty()) continue;
    middles.push_back(0.5 * (box.min + box.max));
    radii.push_back(0.5 * glm::length(box.max - box.min));
  }
  if (radii.empty()) return 0.0;
  glm::dvec3 center;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> coordinates;
    for (const glm::dvec3& middle : middles) coordinates.push_back(middle[axis]);
    center[axis] = lower_median(coordinates);
  }
  for (std::size_t i = 0; i < radii.size(); ++i) radii[i] = std::max(radii[i], glm::length(middles[i] - center));
  return lower_median(radii);
}

}  // namespace etendue
