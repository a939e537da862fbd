#include "bench/ray_sets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <variant>

#include "core/errors.h"
#include "image/vectors.h"
#include "scene/placed.h"

namespace etendue {
namespace {

using glm::dvec3;
constexpr std::uint32_t kTile = 8;  // pixels, as in the film of the device

// The same numbers on every platform: the standard fixes the engine, but not its distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  std::size_t below(std::size_t n) {
    return std::min(n - 1, static_cast<std::size_t>(unit() * static_cast<double>(n)));
  }
  dvec3 direction() {
    const double z = 1.0 - 2.0 * unit(), phi = 2.0 * kPi * unit(), r = std::sqrt(std::max(0.0, 1.0 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
  }

 private:
  std::mt19937_64 engine_;
};

// A surface point in normalised coordinates.
struct Point {
  dvec3 p{0.0}, ng{0.0};
  double error = 0.0;  // how far a ray starts off the surface; the bound of shaders/surface.glsl

  // The point moved off the surface to the side of `w`.
  dvec3 toward(const dvec3& w) const { return p + (glm::dot(w, ng) >= 0.0 ? error : -error) * ng; }
};

// The scene's primitives in normalised coordinates, rounded like those of the device.
class PlacedScene {
 public:
  // A shape of the scene, in world space.
  using PlacedShape = std::variant<PlacedMesh, Sphere>;

  PlacedScene(const Scene& scene, const Placement& placement) : scene_(scene), placement_(placement) {
    for (const Instance& instance : scene.instances) {
      const Shape& shape = scene.shape_of(instance);
      if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) {
        shapes_.emplace_back(PlacedMesh(*mesh, instance));
      } else if (const auto* sphere = std::get_if<Sphere>(&shape)) {
        shapes_.emplace_back(placed_sphere(*sphere, instance));
      } else {
        throw Error(ErrorKind::scene,
                    "rays are measured in scenes of triangles and spheres; this one has disks or cylinders");
      }
    }
  }

  const Scene& scene() const { return scene_; }
  const PlacedShape& shape(std::size_t instance) const { return shapes_[instance]; }
  dvec3 place(const dvec3& p) const { return dvec3(glm::vec3((p - placement_.center) * placement_.scale)); }

  struct Triangle {
    dvec3 p0, p1, p2;
    dvec3 normal() const { return glm::cross(p1 - p0, p2 - p0); }  // its length is twice the area
    double error() const {
      return kErrors * std::max({largest_coordinate(p0), largest_coordinate(p1), largest_coordinate(p2)});
    }
  };
  Triangle triangle(const PlacedMesh& mesh, std::size_t i) const {
    const std::array<dvec3, 3> p = mesh.triangle(i);
    return {place(p[0]), place(p[1]), place(p[2])};
  }
  struct Ball {
    dvec3 center;
    double radius;
    Point point(const dvec3& direction) const {
      return {center + radius * direction, direction, kErrors * (largest_coordinate(center) + radius)};
    }
  };
  Ball ball(const Sphere& sphere) const { return {place(sphere.center), sphere.radius * placement_.scale}; }

  // Where `ray` meets the primitive it was found to hit; nothing when it runs in the primitive's plane.
  std::optional<Point> hit_point(const CastRay& ray, const CastHit& hit) const {
    const dvec3 o(ray.o), d(ray.d);
    const PlacedShape& shape = shapes_[hit.instance];
    if (const auto* sphere = std::get_if<Sphere>(&shape)) {
      const Ball b = ball(*sphere);
      return b.point(glm::normalize(o + static_cast<double>(hit.t) * d - b.center));
    }
    const Triangle tri = triangle(std::get<PlacedMesh>(shape), hit.primitive);
    const dvec3 n = tri.normal();
    const double along = glm::dot(d, n);
    if (along == 0.0) return std::nullopt;
    return Point{o + glm::dot(tri.p0 - o, n) / along * d, glm::normalize(n), tri.error()};
  }

 private:
  static constexpr double kErrors = 8.0 / 8388608.0;
  const Scene& scene_;
  Placement placement_;
  std::vector<PlacedShape> shapes_;  // by instance
};

// Points of the emitters, uniform by area; where nothing emits, points in the box of the scene.
class Targets {
 public:
  explicit Targets(const PlacedScene& placed) : placed_(placed) {
    for (std::size_t k = 0; k < placed.scene().instances.size(); ++k) {
      const bool emits = placed.scene().instances[k].emitter.has_value();
      if (const auto* sphere = std::get_if<Sphere>(&placed.shape(k))) {
        const auto b = placed.ball(*sphere);
        extend(b.center - b.radius), extend(b.center + b.radius);
        if (emits) add(k, 0, 4.0 * kPi * b.radius * b.radius);
        continue;
      }
      const auto& mesh = std::get<PlacedMesh>(placed.shape(k));
      for (std::uint32_t i = 0; i < mesh.mesh().positions.size(); ++i) extend(placed.place(mesh.position(i)));
      for (std::size_t i = 0; emits && i < mesh.triangle_count(); ++i)
        add(k, i, 0.5 * glm::length(placed.triangle(mesh, i).normal()));
    }
  }

  Point choose(Random& random) const {
    if (areas_.empty()) {
      const dvec3 u(random.unit(), random.unit(), random.unit());
      return {lower_ + u * (upper_ - lower_), dvec3(0.0), 0.0};
    }
    const double area = random.unit() * areas_.back();
    const auto found = std::ranges::upper_bound(areas_, area);
    const Entry& entry = entries_[static_cast<std::size_t>(std::min(found, areas_.end() - 1) - areas_.begin())];
    const PlacedScene::PlacedShape& shape = placed_.shape(entry.instance);
    if (const auto* sphere = std::get_if<Sphere>(&shape)) return placed_.ball(*sphere).point(random.direction());
    const auto tri = placed_.triangle(std::get<PlacedMesh>(shape), entry.primitive);
    const double root = std::sqrt(random.unit()), v = random.unit();
    return {tri.p0 + (1.0 - v) * root * (tri.p1 - tri.p0) + v * root * (tri.p2 - tri.p0), glm::normalize(tri.normal()),
            tri.error()};
  }

 private:
  struct Entry {
    std::size_t instance;
    std::size_t primitive;
  };
  void extend(const dvec3& p) {
    lower_ = glm::min(lower_, p);
    upper_ = glm::max(upper_, p);
  }
  void add(std::size_t instance, std::size_t primitive, double area) {
    if (!(area > 0.0)) return;
    entries_.push_back({instance, primitive});
    areas_.push_back((areas_.empty() ? 0.0 : areas_.back()) + area);
  }

  const PlacedScene& placed_;
  dvec3 lower_{std::numeric_limits<double>::infinity()}, upper_{-std::numeric_limits<double>::infinity()};
  std::vector<Entry> entries_;
  std::vector<double> areas_;  // running sums
};

// Tile by tile, through pixel centres; docs/conventions.md, "Camera".
std::vector<CastRay> camera_rays(const Scene& scene, const Placement& placement, std::size_t count) {
  const Camera& camera = scene.camera;
  const double aspect = static_cast<double>(camera.width) / camera.height;
  const auto tiles = [](double pixels) {
    return static_cast<std::uint32_t>(std::clamp(std::floor(pixels / kTile), 1.0, 8192.0));
  };
  const std::uint32_t tiles_x = tiles(std::sqrt(static_cast<double>(count) * aspect));
  const std::uint32_t tiles_y = tiles(std::sqrt(static_cast<double>(count) / aspect));
  const double width = tiles_x * kTile, height = tiles_y * kTile;
  const double tan_x = std::tan(0.5 * camera.fov * kPi / 180.0), tan_y = tan_x / aspect;
  const glm::vec3 origin((dvec3(camera.world_from_camera[3]) - placement.center) * placement.scale);
  std::vector<CastRay> rays;
  rays.reserve(std::size_t{tiles_x} * tiles_y * kTile * kTile);
  for (std::uint32_t i = 0; i < tiles_x * tiles_y * kTile * kTile; ++i) {
    const std::uint32_t tile = i / (kTile * kTile), in_tile = i % (kTile * kTile);
    const std::uint32_t column = tile % tiles_x * kTile + in_tile % kTile;
    const std::uint32_t row = tile / tiles_x * kTile + in_tile / kTile;
    const double x = column + 0.5, y = row + 0.5;
    const dvec3 v = glm::dmat3(camera.world_from_camera) *
                    dvec3(tan_x * (1.0 - 2.0 * x / width), tan_y * (1.0 - 2.0 * y / height), 1.0);
    const double length = glm::length(v);
    rays.push_back({.o = origin,
                    .t_min = static_cast<float>(camera.near_clip * length * placement.scale),
                    .d = glm::vec3(v / length),
                    .t_max = static_cast<float>(camera.far_clip * length * placement.scale)});
  }
  return rays;
}

CastRay bounce(const Point& point, const dvec3& came_along, Random& random) {
  const dvec3 n = glm::dot(point.ng, came_along) < 0.0 ? point.ng : -point.ng;
  // A point of the unit sphere that touches the surface: its direction follows the cosine.
  const dvec3 toward = n + random.direction();
  const dvec3 d = glm::dot(toward, toward) > 0.0 ? glm::normalize(toward) : n;
  return {.o = glm::vec3(point.toward(n)),
          .t_min = 0.0f,
          .d = glm::vec3(d),
          .t_max = std::numeric_limits<float>::infinity()};
}

// True when one of the points lies in the tangent plane of the other, or so near to it that rounding decides about the
// side: the ray may then meet all of that plane or nothing, and no light goes along it. Where lamps stand in one plane,
// the light of one passes the others in just that plane.
bool along_surface(const Point& from, const Point& to) {
  constexpr double kClear = 4.0;  // times what the ends are moved off their surfaces
  const dvec3 v = to.p - from.p;
  const double least = kClear * (from.error + to.error);
  const bool leaves = std::abs(glm::dot(v, from.ng)) > least;
  const bool arrives = to.ng == dvec3(0.0) || std::abs(glm::dot(v, to.ng)) > least;
  return !leaves || !arrives;
}

CastRay shadow(const Point& from, const Point& to) {
  const dvec3 o(glm::vec3(from.toward(to.p - from.p)));
  const dvec3 v = to.toward(from.p - to.p) - o;
  const double distance = glm::length(v);
  const dvec3 d = distance > 0.0 ? v / distance : from.ng;
  return {.o = glm::vec3(o), .t_min = 0.0f, .d = glm::vec3(d), .t_max = static_cast<float>(distance * (1.0 - 1e-6))};
}

std::vector<CastRay> shuffled(std::vector<CastRay> rays, Random& random) {
  for (std::size_t i = rays.size(); i > 1; --i) std::swap(rays[i - 1], rays[random.below(i)]);
  return rays;
}

}  // namespace

std::vector<RaySet> make_ray_sets(const Scene& scene, RayCaster& caster, const RaySetOptions& options) {
  const PlacedScene placed(scene, caster.placement());
  const Targets targets(placed);
  const std::vector<CastRay> primary =
      camera_rays(scene, caster.placement(), std::min(options.count, caster.max_rays()));
  caster.load(primary);
  caster.cast(RayQuery::closest);
  const std::vector<CastHit> hits = caster.hits();
  std::vector<CastRay> diffuse, shadows;
  Random random(options.seed);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].instance == CastHit::kNone) continue;
    const auto point = placed.hit_point(primary[i], hits[i]);
    if (!point) continue;
    diffuse.push_back(bounce(*point, dvec3(primary[i].d), random));
    const Point target = targets.choose(random);
    if (!along_surface(*point, target)) shadows.push_back(shadow(*point, target));
  }
  std::vector<RaySet> sets;
  const auto add = [&](const char* kind, RayQuery query, const std::vector<CastRay>& rays) {
    if (rays.empty()) return;
    sets.push_back({kind, false, query, rays});
    sets.push_back({kind, true, query, shuffled(rays, random)});
  };
  add("primary", RayQuery::closest, primary);
  add("diffuse", RayQuery::closest, diffuse);
  add("shadow", RayQuery::any, shadows);
  return sets;
}

}  // namespace etendue
