#include "reference/world.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "reference/rng.h"
#include "scene/bounds.h"
#include "scene/film_unit.h"
#include "scene/materials.h"

namespace etendue::reference {
namespace {}  // namespace

World::World(const Scene& scene, Rounding rounding)
    : scene_(scene),
      rounding_(rounding),
      lights_(scene),
      environment_(scene, lights_.power()),
      filter_(scene.camera.filter) {
  if (!scene_.delta_lights.empty()) delta_light_limit_ = etendue::delta_light_limit(radiance_exponent(scene_));
  for (const Instance& instance : scene_.instances) {
    placements_.emplace_back(instance);
    passing_.push_back(etendue::may_pass(scene_, instance.material));
  }
  may_pass_ = std::ranges::find(passing_, true) != passing_.end();
  sharing_.emplace(scene_);
  add_meshes(*sharing_);
  primitives_ = collect(*sharing_);
  bvh_ = build(primitives_);
}

/// A hierarchy over primitives, which are brought into the order of its leaves.
Bvh World::build(std::vector<Primitive>& primitives) {
  std::vector<Box> boxes(primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.radius > 0.0) {
      boxes[i].include(p.p0 - Vec3(p.radius));
      boxes[i].include(p.p0 + Vec3(p.radius));
    } else if (p.disk) {
      // In each direction the ellipse reaches as far as its half axes do together.
      const Vec3 reach = glm::sqrt(p.disk->a * p.disk->a + p.disk->b * p.disk->b);
      boxes[i].include(p.disk->center - reach);
      boxes[i].include(p.disk->center + reach);
    } else if (p.tube) {
      const Vec3 axis = p.tube->axis;
      const Vec3 reach = p.tube->radius * glm::sqrt(glm::max(Vec3(0.0), 1.0 - axis * axis));
      for (const Vec3& end : {p.tube->base, p.tube->base + p.tube->height * axis}) {
        boxes[i].include(end - reach);
        boxes[i].include(end + reach);
      }
    } else if (p.whole_mesh) {
      boxes[i].include(p.p0);
      boxes[i].include(p.p1);
    } else {
      for (const Vec3& vertex : {p.p0, p.p1, p.p2}) boxes[i].include(vertex);
    }
  }
  Bvh bvh(boxes);
  std::vector<Primitive> ordered;
  ordered.reserve(primitives.size());
  for (const std::uint32_t i : bvh.order()) ordered.push_back(primitives[i]);
  primitives = std::move(ordered);
  return bvh;
}

void World::add_meshes(const Sharing& sharing) {
  meshes_.resize(scene_.shapes.size());
  for (std::size_t s = 0; s < meshes_.size(); ++s) {
    if (!sharing.has_shape(s)) continue;
    const auto& mesh = std::get<TriangleMesh>(scene_.shapes[s]);
    std::vector<Primitive> primitives;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      const glm::uvec3 t = mesh.triangles[i];
      const Vec3 &p0 = mesh.positions[t.x], &p1 = mesh.positions[t.y], &p2 = mesh.positions[t.z];
      if (!is_degenerate(p0, p1, p2)) primitives.push_back({.p0 = p0, .p1 = p1, .p2 = p2, .index = i});
    }
    meshes_[s].primitives = without_twins(std::move(primitives));
    meshes_[s].bvh = build(meshes_[s].primitives);
  }
}

void World::set_view(const View& view) {
  const Integrator::LightSampler of_the_scene = scene_.integrator.light_sampler;
  scene_.camera = view.camera;
  scene_.sampler = view.sampler;
  scene_.integrator = view.integrator;
  scene_.integrator.light_sampler = of_the_scene;
  filter_ = FilterSampler(view.camera.filter);
}

std::vector<World::Primitive> World::collect(const Sharing& sharing) const {
  std::vector<Primitive> primitives;
  const std::vector<Bounds> bounds = sharing.any() ? instance_bounds(scene_, sharing) : std::vector<Bounds>();
  for (std::uint32_t n = 0; n < scene_.instances.size(); ++n) {
    const Placement& placement = placements_[n];
    const Shape& shape = scene_.shape_of(scene_.instances[n]);
    if (sharing.has_instance(n)) {
      const Bounds& box = bounds[n];
      // Rays are rounded on their way into object space: a little more than what double precision does to them.
      const Vec3 slack =
          Vec3(kMostCondition * 0x1p-48 * largest_coordinate(glm::max(glm::abs(box.min), glm::abs(box.max))));
      if (!meshes_[scene_.instances[n].shape].primitives.empty())
        primitives.push_back({.p0 = box.min - slack, .p1 = box.max + slack, .instance = n, .whole_mesh = true});
      continue;
    }
    if (const auto* object = std::get_if<Sphere>(&shape)) {
      const Sphere sphere = placement.sphere(*object);
      primitives.push_back({.p0 = sphere.center, .radius = sphere.radius, .instance = n, .index = 0});
      continue;
    }
    if (std::holds_alternative<Disk>(shape)) {
      const Ellipse disk = placement.disk();
      primitives.push_back({.p0 = disk.center, .p1 = disk.a, .p2 = disk.b, .instance = n, .disk = disk});
      continue;
    }
    if (const auto* object = std::get_if<Cylinder>(&shape)) {
      const Tube tube = placement.cylinder(*object);
      primitives.push_back(
          {.p0 = tube.base, .p1 = tube.height * tube.axis, .p2 = Vec3(tube.radius), .instance = n, .tube = tube});
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

/// Of primitives with the same vertices in the same order only the first counts: a ray meets all or none of them. Where
/// it may pass that one, those of other instances lie behind.
std::vector<World::Primitive> World::without_twins(std::vector<Primitive> primitives) const {
  const auto key = [&](std::uint32_t i) {
    const Primitive& p = primitives[i];
    return std::tie(p.p0.x, p.p0.y, p.p0.z, p.p1.x, p.p1.y, p.p1.z, p.p2.x, p.p2.y, p.p2.z, p.radius);
  };
  std::vector<std::uint32_t> order(primitives.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    const auto ka = key(a), kb = key(b);
    const auto form = [&](std::uint32_t i) { return primitives[i].disk ? 1 : primitives[i].tube ? 2 : 0; };
    if (form(a) != form(b)) return form(a) < form(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<bool> is_twin(primitives.size(), false);
  const auto alike = [&](const Primitive& a, const Primitive& b) {
    return a.disk.has_value() == b.disk.has_value() && a.tube.has_value() == b.tube.has_value() &&
           (!a.tube || a.tube->side == b.tube->side);
  };
  for (std::size_t i = 1, first = 0; i < order.size(); ++i) {
    const Primitive &p = primitives[order[i]], &standing = primitives[order[first]];
    const bool same = key(order[i]) == key(order[first]) && alike(p, standing);
    is_twin[order[i]] = same && (p.instance == standing.instance || !passing_[standing.instance]);
    if (!is_twin[order[i]]) first = i;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (!is_twin[i]) primitives[kept++] = primitives[i];
  }
  primitives.resize(kept);
  return primitives;
}

void World::meet(const Primitive& p, std::uint32_t instance, const Ray& ray, const TriangleTest& test, double& t_max,
                 Found& found) {
  if (ray.passed && instance >= ray.passed->instance) {
    Ray reaching = ray;
    reaching.t_min = instance == ray.passed->instance ? ray.passed->t_own : std::nextafter(ray.t_min, -1.0);
    reaching.passed.reset();
    return meet(p, instance, reaching, TriangleTest(reaching), t_max, found);
  }
  // Among equally near surfaces the first of the scene is the one that is met, whatever the order of the tree.
  const bool precedes = found.any && std::pair(instance, p.index) < std::pair(found.instance, found.index);
  const double reach = precedes ? std::nextafter(t_max, INFINITY) : t_max;
  std::optional<TriangleHit> hit;
  if (p.radius > 0.0) {
    if (const auto t = intersect_sphere(ray, p.p0, p.radius, reach)) hit = TriangleHit{.t = *t};
  } else if (p.disk) {
    if (const auto t = intersect(ray, *p.disk, reach)) hit = TriangleHit{.t = *t};
  } else if (p.tube) {
    if (const auto t = intersect(ray, *p.tube, reach)) hit = TriangleHit{.t = *t};
  } else {
    hit = test(p.p0, p.p1, p.p2, reach);
  }
  if (!hit) return;
  t_max = hit->t;
  found = {.any = true,
           .instance = instance,
           .index = p.index,
           .radius = p.radius,
           .center = p.p0,
           .disk = p.disk,
           .tube = p.tube,
           .hit = *hit};
}

namespace {

/// Even in the cube of ±1, always the same for a vector.
Vec3 jitter(const Vec3& of) {
  Words words{};
  for (int i = 0; i < 3; ++i) {
    const auto bits = std::bit_cast<std::uint64_t>(of[i]);
    words[0] ^= static_cast<std::uint32_t>(bits);
    words[1] ^= static_cast<std::uint32_t>(bits >> 32);
    words = pcg4d(words);
  }
  return 2.0 * Vec3(unit_float(words[0]), unit_float(words[1]), unit_float(words[2])) - 1.0;
}

}  // namespace

std::optional<Surface> World::closest_hit(const Ray& exact) const {
  Ray ray = exact;
  if (rounding_ == Rounding::single) ray.direction = glm::normalize(ray.direction + 0x1p-23 * jitter(ray.direction));
  // A ray that is none would meet every box of the tree; it misses, and the sample becomes not a number.
  if (!is_finite(ray.origin + ray.direction)) return std::nullopt;
  const TriangleTest triangle_test(ray);
  Found found;
  bvh_.traverse(ray, [&](std::uint32_t position, double& t_max) {
    const Primitive& p = primitives_[position];
    if (!p.whole_mesh) {
      meet(p, p.instance, ray, triangle_test, t_max, found);
      return false;
    }
    Ray local = placements_[p.instance].to_object(ray);
    local.t_max = t_max;
    const TriangleTest local_test(local);
    const Mesh& mesh = meshes_[scene_.instances[p.instance].shape];
    mesh.bvh.traverse(local, [&](std::uint32_t at, double& t) {
      meet(mesh.primitives[at], p.instance, local, local_test, t, found);
      t_max = t;
      return false;
    });
    return false;
  });
  if (!found.any) return std::nullopt;
  Surface met = surface(found, ray.origin + found.hit.t * ray.direction);
  met.t = found.hit.t;
  if (rounding_ == Rounding::single) shake(met);
  return met;
}

// Coordinates of single precision have 24 bits. A point is the sum of three products of weights and vertices: about two
// units of the largest coordinate, and twice that where vertices and rays are moved between two spaces on the way. Rays
// leave it by the eight units that a device's own rays are given, or those of both spaces.
void World::shake(Surface& surface) const {
  const bool shared = sharing_->has_instance(surface.instance);
  const double magnitude = surface.magnitude * (shared ? 2.0 / kMostCondition : 1.0);
  surface.p += jitter(surface.p) * (0x1p-23 * magnitude);
  surface.magnitude = magnitude * (0x1p-20 / Surface::kRelativeOffset);
}

Surface World::surface(const Found& found, const Vec3& near_point) const {
  if (found.radius > 0.0) return sphere_surface(found, near_point, scene_.instances[found.instance].flip_normals);
  if (found.disk) return disk_surface(found, near_point);
  if (found.tube) return tube_surface(found, near_point);
  return triangle_surface(found);
}

bool World::occluded(const Vec3& from, const Vec3& to) const {
  const double distance = glm::length(to - from);
  if (!(distance > 0.0)) return false;  // no direction to look in
  const Ray ray{.origin = from, .direction = (to - from) / distance, .t_min = 0.0, .t_max = distance};
  const TriangleTest triangle_test(ray);
  return bvh_.traverse(ray, [&](std::uint32_t position, double& t_max) {
    const Primitive& p = primitives_[position];
    if (p.radius > 0.0) return intersect_sphere(ray, p.p0, p.radius, t_max).has_value();
    if (p.disk) return intersect(ray, *p.disk, t_max).has_value();
    if (p.tube) return intersect(ray, *p.tube, t_max).has_value();
    if (!p.whole_mesh) return triangle_test(p.p0, p.p1, p.p2, t_max).has_value();
    const Ray local = placements_[p.instance].to_object(ray);
    const TriangleTest local_test(local);
    const Mesh& mesh = meshes_[scene_.instances[p.instance].shape];
    return mesh.bvh.traverse(local, [&](std::uint32_t at, double& t) {
      const Primitive& q = mesh.primitives[at];
      return local_test(q.p0, q.p1, q.p2, t).has_value();
    });
  });
}

bool World::escapes(const Vec3& from, const Vec3& direction) const {
  return !closest_hit({.origin = from, .direction = direction, .t_min = 0.0, .t_max = INFINITY}).has_value();
}

Surface World::triangle_surface(const Found& found) const {
  const auto& mesh = std::get<TriangleMesh>(scene_.shape_of(scene_.instances[found.instance]));
  const Placement& placement = placements_[found.instance];
  const bool shared = sharing_->has_instance(found.instance);
  Vec3 b = found.hit.barycentric;
  if (shared && placement.turned()) std::swap(b.y, b.z);
  const std::array<Vec3, 3> p = placement.triangle(mesh, found.index);
  // From the vertices, not along the ray: this point's error depends on the triangle alone, however far the ray came.
  Surface surface{.p = b.x * p[0] + b.y * p[1] + b.z * p[2],
                  .ng = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0])),
                  .instance = found.instance,
                  .primitive = found.index,
                  .weights = b};
  for (const Vec3& vertex : p) surface.magnitude = std::max(surface.magnitude, largest_coordinate(vertex));
  if (shared) surface.magnitude *= kMostCondition;
  surface.ns = placement.shading_normal(mesh, found.index, b, surface.ng);
  return surface;
}

Surface World::sphere_surface(const Found& found, const Vec3& near_point, bool inward) {
  const Vec3 outward = glm::normalize(near_point - found.center), normal = inward ? -outward : outward;
  return {.p = found.center + found.radius * outward,
          .ng = normal,
          .ns = normal,
          .magnitude = largest_coordinate(found.center) + found.radius,
          .instance = found.instance,
          .primitive = 0};
}

Surface World::disk_surface(const Found& found, const Vec3& near_point) {
  const Ellipse& disk = *found.disk;
  const Vec2 xy = disk.coordinates(near_point);
  const Vec3 normal = disk.normal();
  return {.p = disk.center + xy.x * disk.a + xy.y * disk.b,
          .ng = normal,
          .ns = normal,
          .magnitude = largest_coordinate(disk.center) + largest_coordinate(disk.a) + largest_coordinate(disk.b),
          .instance = found.instance,
          .primitive = 0};
}

Surface World::tube_surface(const Found& found, const Vec3& near_point) {
  const Tube& tube = *found.tube;
  const Vec3 outward = tube.outward(near_point);
  return {.p = tube.base + tube.along(near_point) * tube.axis + tube.radius * outward,
          .ng = tube.side * outward,
          .ns = tube.side * outward,
          .magnitude = largest_coordinate(tube.base) + tube.height + tube.radius,
          .instance = found.instance,
          .primitive = 0};
}

}  // namespace etendue::reference
