#include "reference/world.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "reference/intersect.h"

namespace etendue::reference {
namespace {

double largest_coordinate(const Vec3& v) {
  return max_component(glm::abs(v));
}

}  // namespace

World::World(const Scene& scene) : scene_(scene), lights_(scene), filter_(scene.camera.filter) {
  for (const Instance& instance : scene_.instances) placements_.emplace_back(instance);
  const std::vector<Primitive> unordered = collect();
  std::vector<Box> boxes(unordered.size());
  for (std::size_t i = 0; i < unordered.size(); ++i) {
    const Primitive& p = unordered[i];
    if (p.radius > 0.0) {
      boxes[i].include(p.p0 - Vec3(p.radius));
      boxes[i].include(p.p0 + Vec3(p.radius));
    } else {
      for (const Vec3& vertex : {p.p0, p.p1, p.p2}) boxes[i].include(vertex);
    }
  }
  bvh_ = Bvh(boxes);
  primitives_.reserve(unordered.size());
  for (const std::uint32_t i : bvh_.order()) primitives_.push_back(unordered[i]);
}

void World::set_view(const View& view) {
  const Integrator::LightSampler of_the_scene = scene_.integrator.light_sampler;
  scene_.camera = view.camera;
  scene_.sampler = view.sampler;
  scene_.integrator = view.integrator;
  scene_.integrator.light_sampler = of_the_scene;
  filter_ = FilterSampler(view.camera.filter);
}

std::vector<World::Primitive> World::collect() const {
  std::vector<Primitive> primitives;
  for (std::uint32_t n = 0; n < scene_.instances.size(); ++n) {
    const Placement& placement = placements_[n];
    const Shape& shape = scene_.shape_of(scene_.instances[n]);
    if (const auto* object = std::get_if<Sphere>(&shape)) {
      const Sphere sphere = placement.sphere(*object);
      primitives.push_back({.p0 = sphere.center, .radius = sphere.radius, .instance = n, .index = 0});
      continue;
    }
    const auto& mesh = std::get<TriangleMesh>(shape);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [p0, p1, p2] = placement.triangle(mesh, i);
      if (!is_degenerate(p0, p1, p2))
        primitives.push_back({.p0 = p0, .p1 = p1, .p2 = p2, .radius = 0.0, .instance = n, .index = i});
    }
  }
  return without_twins(std::move(primitives));
}

/// Of primitives with the same vertices in the same order only the first counts: a ray meets all or none of them.
std::vector<World::Primitive> World::without_twins(std::vector<Primitive> primitives) {
  const auto key = [&](std::uint32_t i) {
    const Primitive& p = primitives[i];
    return std::tie(p.p0.x, p.p0.y, p.p0.z, p.p1.x, p.p1.y, p.p1.z, p.p2.x, p.p2.y, p.p2.z, p.radius);
  };
  std::vector<std::uint32_t> order(primitives.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    const auto ka = key(a), kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<bool> is_twin(primitives.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i) is_twin[order[i]] = key(order[i]) == key(order[i - 1]);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (!is_twin[i]) primitives[kept++] = primitives[i];
  }
  primitives.resize(kept);
  return primitives;
}

std::optional<Surface> World::closest_hit(const Ray& ray) const {
  // A ray that is none would meet every box of the tree; it misses, and the sample becomes not a number.
  if (!is_finite(ray.origin + ray.direction)) return std::nullopt;
  const TriangleTest triangle_test(ray);
  const Primitive* nearest = nullptr;
  TriangleHit hit;
  // Among equally near surfaces the first of the scene is the one that is met, whatever the order of the tree.
  const auto precedes = [](const Primitive& a, const Primitive& b) {
    return std::pair(a.instance, a.index) < std::pair(b.instance, b.index);
  };
  bvh_.traverse(ray, [&](std::uint32_t position, double& t_max) {
    const Primitive& p = primitives_[position];
    const double reach = nearest != nullptr ? std::nextafter(t_max, INFINITY) : t_max;
    std::optional<TriangleHit> found;
    if (p.radius > 0.0) {
      if (const auto t = intersect_sphere(ray, p.p0, p.radius, reach)) found = TriangleHit{.t = *t};
    } else {
      found = triangle_test(p.p0, p.p1, p.p2, reach);
    }
    if (!found || (found->t == t_max && nearest != nullptr && precedes(*nearest, p))) return false;
    hit = *found;
    t_max = hit.t;
    nearest = &p;
    return false;
  });
  if (nearest == nullptr) return std::nullopt;
  if (nearest->radius > 0.0) return sphere_surface(*nearest, ray.origin + hit.t * ray.direction);
  return triangle_surface(*nearest, hit.barycentric);
}

bool World::occluded(const Vec3& from, const Vec3& to) const {
  const double distance = glm::length(to - from);
  if (!(distance > 0.0)) return false;  // no direction to look in
  const Ray ray{.origin = from, .direction = (to - from) / distance, .t_min = 0.0, .t_max = distance};
  const TriangleTest triangle_test(ray);
  return bvh_.traverse(ray, [&](std::uint32_t position, double& t_max) {
    const Primitive& p = primitives_[position];
    if (p.radius > 0.0) return intersect_sphere(ray, p.p0, p.radius, t_max).has_value();
    return triangle_test(p.p0, p.p1, p.p2, t_max).has_value();
  });
}

Surface World::triangle_surface(const Primitive& primitive, const Vec3& b) const {
  // From the vertices, not along the ray: this point's error depends on the triangle alone, however far the ray came.
  Surface surface{.p = b.x * primitive.p0 + b.y * primitive.p1 + b.z * primitive.p2,
                  .ng = glm::normalize(glm::cross(primitive.p1 - primitive.p0, primitive.p2 - primitive.p0)),
                  .instance = primitive.instance,
                  .primitive = primitive.index};
  for (const Vec3& vertex : {primitive.p0, primitive.p1, primitive.p2})
    surface.magnitude = std::max(surface.magnitude, largest_coordinate(vertex));
  const auto& mesh = std::get<TriangleMesh>(scene_.shape_of(scene_.instances[primitive.instance]));
  surface.ns = placements_[primitive.instance].shading_normal(mesh, primitive.index, b, surface.ng);
  return surface;
}

Surface World::sphere_surface(const Primitive& primitive, const Vec3& near_point) const {
  const Vec3 normal = glm::normalize(near_point - primitive.p0);
  return {.p = primitive.p0 + primitive.radius * normal,
          .ng = normal,
          .ns = normal,
          .magnitude = largest_coordinate(primitive.p0) + primitive.radius,
          .instance = primitive.instance,
          .primitive = 0};
}

Vec3 World::sky(const Vec3& w) const {
  return glm::mix(scene_.sky.horizon, scene_.sky.top, std::clamp(w.y, 0.0, 1.0));
}

}  // namespace etendue::reference
