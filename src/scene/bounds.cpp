#include "scene/bounds.h"

#include "scene/placed.h"

namespace etendue {

Bounds bounds_of(const Scene& scene, const Instance& instance) {
  Bounds box;
  const Shape& shape = scene.shape_of(instance);
  if (const auto* object = std::get_if<Sphere>(&shape)) {
    const Sphere sphere = placed_sphere(*object, instance);
    box.add(sphere.center - sphere.radius);
    box.add(sphere.center + sphere.radius);
  } else {
    const PlacedMesh mesh(std::get<TriangleMesh>(shape), instance);
    for (std::uint32_t i = 0; i < mesh.mesh().positions.size(); ++i) box.add(mesh.position(i));
  }
  return box;
}

Bounds bounds_of(const Scene& scene) {
  Bounds all;
  for (const Instance& instance : scene.instances) {
    const Bounds box = bounds_of(scene, instance);
    all.add(box.min);
    all.add(box.max);
  }
  return all;
}

}  // namespace etendue
