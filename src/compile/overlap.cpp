#include "compile/overlap.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "compile/twins.h"
#include "core/parallel.h"
#include "scene/bounds.h"
#include "scene/placed.h"

namespace etendue {
namespace {

/// The boxes that the device uses, in normalised coordinates, instance by instance.
std::vector<gpu::Primitive> collect(const Scene& scene, const Normalization& normalization) {
  std::vector<gpu::Primitive> primitives;
  const Sharing sharing(scene);
  const std::vector<Bounds> boxes = sharing.any() ? instance_bounds(scene, sharing) : std::vector<Bounds>();
  for (std::uint32_t n = 0; n < scene.instances.size(); ++n) {
    const Instance& instance = scene.instances[n];
    gpu::Primitive p{};
    p.instance = n;
    if (sharing.has_instance(n)) {  // counts as one box, represented by three corners
      p.p0 = normalization.point(boxes[n].min);
      p.p1 = normalization.point(boxes[n].max);
      p.p2 = {p.p0.x, p.p1.y, p.p0.z};
      p.kind = gpu::kPrimitiveTriangle;
      primitives.push_back(p);
      continue;
    }
    if (const auto* shape = std::get_if<Sphere>(&scene.shape_of(instance))) {
      const Sphere sphere = placed_sphere(*shape, instance);
      p.kind = gpu::kPrimitiveSphere;
      p.p0 = normalization.point(sphere.center);
      p.p1.x = static_cast<float>(sphere.radius * normalization.scale);
      primitives.push_back(p);
      continue;
    }
    if (!std::holds_alternative<TriangleMesh>(scene.shape_of(instance))) {  // also by its box
      const Bounds box = bounds_of(scene, instance);
      p.p0 = normalization.point(box.min);
      p.p1 = normalization.point(box.max);
      p.p2 = {p.p0.x, p.p1.y, p.p0.z};
      p.kind = gpu::kPrimitiveTriangle;
      primitives.push_back(p);
      continue;
    }
    const PlacedMesh mesh(std::get<TriangleMesh>(scene.shape_of(instance)), instance);
    p.kind = gpu::kPrimitiveTriangle;
    for (std::size_t i = 0; i < mesh.triangle_count(); ++i) {
      const auto [p0, p1, p2] = mesh.triangle(i);
      p.p0 = normalization.point(p0);
      p.p1 = normalization.point(p1);
      p.p2 = normalization.point(p2);
      primitives.push_back(p);
    }
  }
  return primitives;
}

Box box_of(const gpu::Primitive& p) {
  Box box;
  if (p.kind == gpu::kPrimitiveSphere) {
    box.extend(p.p0 - p.p1.x);
    box.extend(p.p0 + p.p1.x);
  } else {
    for (const glm::vec3& v : {p.p0, p.p1, p.p2}) box.extend(v);
  }
  return box;
}

bool contains(const Box& b, const glm::vec3& p) {
  return glm::all(glm::lessThanEqual(b.lower, p)) && glm::all(glm::lessThanEqual(p, b.upper));
}

/// The slab test. Zeros in a direction become tiny numbers, so that no product is 0 · infinity.
bool meets(const Box& b, const glm::vec3& o, const glm::vec3& inverse, float distance) {
  const glm::vec3 t0 = (b.lower - o) * inverse, t1 = (b.upper - o) * inverse;
  const glm::vec3 near = glm::min(t0, t1), far = glm::max(t0, t1);
  return std::max({near.x, near.y, near.z, 0.0f}) <= std::min({far.x, far.y, far.z, distance});
}

/// Sum of `count(i)` over i < n, computed by all threads.
template <typename Count>
std::size_t sum_in_parallel(std::size_t n, const Count& count) {
  std::atomic<std::size_t> sum = 0;
  parallel_for(n, 1 << 16, [&](std::uint64_t begin, std::uint64_t end) {
    std::size_t part = 0;
    for (std::uint64_t i = begin; i < end; ++i) part += count(i) ? 1 : 0;
    sum += part;
  });
  return sum;
}

}  // namespace

Crowding::Crowding(const Scene& scene) : normalization_(find_normalization(scene)) {
  const std::vector<gpu::Primitive> primitives = collect(scene, normalization_);
  std::vector<bool> left_out(primitives.size(), false);
  for (const Twin& twin : find_twins(primitives)) left_out[twin.primitive] = true;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (left_out[i]) continue;
    boxes_.push_back(box_of(primitives[i]));
    instances_.push_back(primitives[i].instance);
  }
}

std::optional<Crowding::Place> Crowding::find_place() const {
  constexpr std::size_t kMostTests = 200'000'000;  // some tenths of a second
  if (boxes_.empty()) return std::nullopt;
  const std::size_t places = std::min(boxes_.size(), std::clamp<std::size_t>(kMostTests / boxes_.size(), 64, 512));
  std::optional<Place> fullest;
  for (std::size_t k = 0; k < places; ++k) {
    const std::size_t i = k * boxes_.size() / places;
    const glm::vec3 p = boxes_[i].center();
    const std::size_t count = sum_in_parallel(boxes_.size(), [&](std::size_t j) { return contains(boxes_[j], p); });
    if (fullest && count <= fullest->count) continue;
    fullest = Place{glm::dvec3(p) / normalization_.scale + normalization_.center, count, instances_[i]};
  }
  return fullest;
}

std::size_t Crowding::count_along(const glm::dvec3& origin, const glm::dvec3& direction, double distance) const {
  const glm::vec3 o((origin - normalization_.center) * normalization_.scale);
  const glm::dvec3 d = direction * normalization_.scale;
  glm::vec3 inverse;
  for (int axis = 0; axis < 3; ++axis)
    inverse[axis] = static_cast<float>(1.0 / (std::abs(d[axis]) > 1e-20 ? d[axis] : 1e-20));
  const auto end = static_cast<float>(distance);
  return sum_in_parallel(boxes_.size(), [&](std::size_t j) { return meets(boxes_[j], o, inverse, end); });
}

}  // namespace etendue
