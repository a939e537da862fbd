/// The walk of the tree against testing every primitive, on soups made to break trees; and rays that leave surfaces.

#include <algorithm>
#include <cmath>
#include <functional>

#include "compile/normalization.h"
#include "device_test.h"
#include "reference_scenes.h"

namespace etendue::test {
namespace {

using reference::test::Body;
using reference::test::box;
using reference::test::diffuse;

class DeviceTrace : public DeviceTest {
 protected:
  std::vector<gpu::TraceAnswer> trace(const CompiledScene& compiled, const std::vector<gpu::RayCase>& rays) {
    const CompiledScene scene = list_primitives(compiled);
    return run<gpu::TraceAnswer>({kernels::traversal, "traversal", &scene, {}}, rays);
  }
  // The nearest hit of the walk is that of the loop to the bit; where several primitives lie at the same distance, any
  // of them. The loop asks the triangle test about triangles far off the ray, too, and there rounding alone may call a
  // triangle hit that is seen edge-on or is tiny against its distance; the boxes rightly miss those. So where the two
  // differ, double precision decides whether the loop's primitive is clearly hit, which fails the test; `unclear`
  // bounds the share of the other cases.
  void compare(const char* what, const Scene& scene, const std::vector<gpu::RayCase>& rays, double least_hits,
               double unclear = 0.0) {
    const CompiledScene compiled = compile_scene(scene);
    const Normalization norm = find_normalization(scene);
    const auto answers = trace(compiled, rays);
    std::size_t hits = 0, excused = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const gpu::TraceAnswer& a = answers[i];
      const bool hit = a.brute_instance != gpu::kNone;
      hits += hit;
      const bool same_nearest =
          a.t == a.brute_t && (a.ties > 1 || (a.instance == a.brute_instance && a.primitive == a.brute_primitive));
      if (same_nearest && a.any == (hit ? 1u : 0u)) continue;
      ASSERT_TRUE(hit) << what << ": the walk found what does not exist, ray " << i;
      const glm::vec3 &o = rays[i].o, &d = rays[i].d;
      const double rounding = 2e-6 * (1.0 + glm::length(glm::dvec3(o)));
      const bool same_distance = std::abs(double{a.t} - a.brute_t) < rounding && a.any == 1u;
      const double inside =
          distance_inside(scene.shape_of(scene.instances[a.brute_instance]), a.brute_primitive, norm, rays[i]);
      ASSERT_TRUE(same_distance || inside < rounding)
          << what << ", ray " << i << " from " << o.x << ' ' << o.y << ' ' << o.z << " to " << d.x << ' ' << d.y << ' '
          << d.z << ": found instance " << a.instance << " at " << a.t << " (any hit: " << a.any
          << "), expected instance " << a.brute_instance << " primitive " << a.brute_primitive << " at " << a.brute_t
          << ", hit " << inside << " inside its outline";
      ++excused;
    }
    RecordProperty(std::string(what) + "_unclear", static_cast<int>(excused));
    EXPECT_LE(static_cast<double>(excused), unclear * static_cast<double>(rays.size())) << what;
    EXPECT_GE(static_cast<double>(hits), least_hits * static_cast<double>(rays.size()))
        << what << ": the test hardly tests";
  }

 private:
  // How far inside the outline of a primitive, which lies in the world as it is, the ray passes, perpendicular to the
  // ray, in double precision; negative outside.
  static double distance_inside(const Shape& shape, std::uint32_t primitive, const Normalization& norm,
                                const gpu::RayCase& ray) {
    const glm::dvec3 o = ray.o, d = glm::normalize(glm::dvec3(ray.d));
    const auto project = [&](const glm::dvec3& p) {
      const glm::dvec3 v = glm::dvec3(norm.point(p)) - o;
      return v - glm::dot(v, d) * d;
    };
    if (const auto* sphere = std::get_if<Sphere>(&shape))
      return sphere->radius * norm.scale - glm::length(project(sphere->center));
    const auto& mesh = std::get<TriangleMesh>(shape);
    const glm::uvec3 t = mesh.triangles[primitive];
    const glm::dvec3 p0 = norm.point(mesh.positions[t.x]);
    const glm::dvec3 normal =
        glm::cross(glm::dvec3(norm.point(mesh.positions[t.y])) - p0, glm::dvec3(norm.point(mesh.positions[t.z])) - p0);
    if (std::abs(glm::dot(normal, d)) <= 1e-6 * glm::length(normal)) return -INFINITY;  // edge-on: it has no inside
    double nearest = INFINITY;
    int left = 0, right = 0;
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 a = project(mesh.positions[t[k]]), ab = project(mesh.positions[t[(k + 1) % 3]]) - a;
      (glm::dot(glm::cross(ab, a), d) < 0.0 ? left : right) += 1;
      const double along = glm::dot(ab, ab) > 0.0 ? std::clamp(-glm::dot(a, ab) / glm::dot(ab, ab), 0.0, 1.0) : 0.0;
      nearest = std::min(nearest, glm::length(a + along * ab));
    }
    return left == 3 || right == 3 ? nearest : -nearest;
  }
};

glm::vec3 unit(const glm::dvec3& v) {
  return glm::vec3(glm::normalize(v));
}

// World coordinates of a ray's ends to device coordinates.
gpu::RayCase ray_between(const Normalization& n, const glm::dvec3& from, const glm::dvec3& to) {
  const glm::vec3 o = n.point(from);
  return {o, 0.0f, unit(glm::dvec3(n.point(to)) - glm::dvec3(o)), INFINITY};
}

// Rays of every kind through a scene that lies within [−half, half]³.
std::vector<gpu::RayCase> mixed_rays(const Scene& scene, double half, std::size_t n, std::uint64_t seed) {
  Random random(seed);
  const Normalization norm = find_normalization(scene);
  const auto point = [&](double h) { return glm::dvec3(random.point(static_cast<float>(h))); };
  std::vector<gpu::RayCase> rays;
  for (std::size_t i = 0; i < n; ++i) {
    glm::dvec3 from = point(i % 2 == 0 ? half : 3.0 * half), to = point(half);
    if (i % 7 == 0) {  // along an axis, sometimes exactly within the plane of a coordinate
      const int axis = static_cast<int>(random.below(3));
      to = from;
      to[axis] += random.unit() < 0.5f ? -1.0 : 1.0;
      if (i % 14 == 0) from[(axis + 1) % 3] = to[(axis + 1) % 3] = 0.0;
    }
    gpu::RayCase ray = ray_between(norm, from, to);
    if (i % 7 == 0) ray.d = glm::round(ray.d);
    if (i % 3 == 0) ray.t_max = random.unit();
    if (i % 11 == 0) ray.t_min = 0.1f * random.unit();
    rays.push_back(ray);
  }
  return rays;
}

Scene with_bodies(const std::vector<Body>& bodies) {
  Scene scene;
  for (const Body& body : bodies) reference::test::add(scene, body);
  return scene;
}

// `count` triangles with vertices from `vertex`.
TriangleMesh soup(std::size_t count, const std::function<glm::dvec3(std::size_t triangle, int corner)>& vertex) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(vertex(i, k));
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

TEST_F(DeviceTrace, RandomSoup) {
  for (const std::size_t count : {1u, 2u, 3u, 5u, 9u, 40u, 800u}) {
    Random random(count);
    glm::dvec3 middle{};
    const Scene scene = with_bodies({Body{soup(count,
                                               [&](std::size_t, int corner) {
                                                 if (corner == 0) middle = random.point(1.0f);
                                                 return middle + glm::dvec3(random.point(count < 50 ? 0.6f : 0.15f));
                                               }),
                                          diffuse(0.5)}});
    compare("random soup", scene, mixed_rays(scene, 1.0, 4096, count), count < 10 ? 0.001 : 0.05);
  }
}

TEST_F(DeviceTrace, SoupWithDegenerateAndDoubledTriangles) {
  Random random(11);
  TriangleMesh mesh = soup(300, [&](std::size_t i, int corner) {
    const glm::dvec3 p = glm::dvec3(random.point(1.0f));
    return i % 5 == 0 && corner > 0 ? glm::dvec3(0.1, 0.2, 0.3) : p;  // two equal corners
  });
  for (std::uint32_t i = 0; i < 300; i += 3) mesh.triangles.push_back(mesh.triangles[i]);  // doubled
  for (std::uint32_t i = 0; i < 60; ++i) mesh.triangles.push_back({7, 7, 7});              // points, all at one place
  for (std::uint32_t i = 0; i < 30; ++i) mesh.triangles.push_back(mesh.triangles[1]);      // one triangle 31 times
  const Scene scene = with_bodies({Body{mesh, diffuse(0.5)}});
  compare("degenerate and doubled", scene, mixed_rays(scene, 1.0, 4096, 12), 0.3);
}

TEST_F(DeviceTrace, HugeAndTinyTogether) {
  Random random(13);
  const TriangleMesh tiny = soup(500, [&, middle = glm::dvec3(0)](std::size_t, int corner) mutable {
    if (corner == 0) middle = 0.01 * glm::dvec3(random.point(1.0f));
    return middle + 0.001 * glm::dvec3(random.point(1.0f));
  });
  const TriangleMesh huge = soup(20, [&](std::size_t, int) { return 50.0 * glm::dvec3(random.point(1.0f)); });
  const Scene scene =
      with_bodies({Body{tiny, diffuse(0.5)}, Body{huge, diffuse(0.5)}, Body{Sphere{{0, -1000, 0}, 999.9}, diffuse(0.5)},
                   Body{Sphere{{0.005, 0, 0}, 0.0005}, diffuse(0.5)}});
  compare("huge and tiny, near", scene, mixed_rays(scene, 0.01, 4096, 14), 0.3, 2e-3);
  compare("huge and tiny, far", scene, mixed_rays(scene, 50.0, 4096, 15), 0.3, 2e-3);
}

TEST_F(DeviceTrace, FlatBoxes) {
  // Axis-aligned grids: boxes without thickness, rays within their planes, and edges met head-on.
  std::vector<Body> bodies;
  for (int axis = 0; axis < 3; ++axis) {
    for (int k = -2; k <= 2; ++k) {
      TriangleMesh mesh = soup(72, [&](std::size_t i, int corner) {
        const std::size_t quad = i / 2, column = quad % 6, row = quad / 6;   // 36 of them, two triangles each
        const int c = i % 2 == 0 ? corner : (corner == 0 ? 0 : corner + 1);  // corners 0 1 2 and 0 2 3
        const double x = static_cast<double>(column) + (c == 1 || c == 2) - 3.0,
                     y = static_cast<double>(row) + (c >= 2) - 3.0;
        glm::dvec3 p;
        p[axis] = 0.5 * k;
        p[(axis + 1) % 3] = x / 3.0;
        p[(axis + 2) % 3] = y / 3.0;
        return p;
      });
      if (k % 2 == 0) bodies.push_back(Body{std::move(mesh), diffuse(0.5)});
    }
  }
  const Scene scene = with_bodies(bodies);
  compare("flat boxes", scene, mixed_rays(scene, 1.0, 8192, 16), 0.4, 2e-3);
  // From lattice point to lattice point: through edges and vertices all the way.
  Random random(17);
  const Normalization norm = find_normalization(scene);
  std::vector<gpu::RayCase> rays;
  for (int i = 0; i < 4096; ++i) {
    const auto lattice = [&](double step, int n) { return step * (static_cast<double>(random.below(2 * n + 1)) - n); };
    const glm::dvec3 from(lattice(0.5, 4), lattice(1.0 / 3, 6), lattice(0.5, 4));
    const glm::dvec3 to(lattice(1.0 / 3, 3), lattice(0.5, 2), lattice(1.0 / 3, 3));
    if (glm::length(to - from) > 0.01) rays.push_back(ray_between(norm, from, to));
  }
  compare("lattice", scene, rays, 0.3, 5e-2);  // many rays lie within the planes of triangles
}

TEST_F(DeviceTrace, SpheresAmongTriangles) {
  Random random(18);
  std::vector<Body> bodies;
  for (int i = 0; i < 200; ++i) {
    bodies.push_back(
        Body{Sphere{glm::dvec3(random.point(1.0f)), std::exp2(random.uniform(-7.0f, -2.0f))}, diffuse(0.5)});
    const int shell = i / 10 + 1;
    if (i % 10 == 0) bodies.push_back(Body{Sphere{{0.5, 0.5, 0.5}, 0.01 * shell}, diffuse(0.5)});  // in one another
  }
  bodies.push_back(Body{soup(200, [&](std::size_t, int) { return glm::dvec3(random.point(1.0f)); }), diffuse(0.5)});
  const Scene scene = with_bodies(bodies);
  compare("spheres", scene, mixed_rays(scene, 1.0, 4096, 19), 0.3);
}

TEST_F(DeviceTrace, LineOfManyBoxes) {
  // All centroids on one line, most of them equal: splits by position do not exist.
  const Scene scene = with_bodies({Body{soup(600,
                                             [](std::size_t i, int corner) {
                                               const double size = 1.0 + static_cast<double>(i % 60) * 0.01;
                                               return glm::dvec3(corner == 1   ? size
                                                                 : corner == 2 ? -size
                                                                               : 0.0,
                                                                 corner == 0 ? 2.0 * size : -size,
                                                                 i < 500 ? 0.0 : static_cast<double>(i) * 1e-3);
                                             }),
                                        diffuse(0.5)}});
  compare("equal centroids", scene, mixed_rays(scene, 2.0, 4096, 20), 0.05, 2e-3);
}

TEST_F(DeviceTrace, EmptyScene) {
  const CompiledScene compiled = compile_scene(Scene{});
  constexpr int kRays = 256;
  std::vector<gpu::RayCase> rays;
  rays.reserve(kRays);
  Random random(21);
  for (int i = 0; i < kRays; ++i)
    rays.push_back({random.point(i % 2 == 0 ? 0.0f : 1.0f), 0.0f, glm::vec3(random.direction()), INFINITY});
  for (const auto& a : trace(compiled, rays)) {
    EXPECT_EQ(a.instance, gpu::kNone);
    EXPECT_EQ(a.any, 0u);
  }
}

// Nearest and second nearest hit in double precision over all triangles.
struct Nearest {
  double t = INFINITY, second = INFINITY,
         margin = INFINITY;  // margin: smallest barycentric distance from an edge of anything near
  std::uint32_t primitive = gpu::kNone;
};
Nearest nearest(const std::vector<glm::dvec3>& p, const gpu::RayCase& ray) {
  Nearest best;
  const glm::dvec3 o = ray.o, d = ray.d;
  for (std::size_t i = 0; i < p.size() / 3; ++i) {
    const glm::dvec3 e1 = p[3 * i + 1] - p[3 * i], e2 = p[3 * i + 2] - p[3 * i], h = glm::cross(d, e2),
                     s = o - p[3 * i], q = glm::cross(s, e1);
    const double det = glm::dot(e1, h);
    if (det == 0.0) continue;
    const double u = glm::dot(s, h) / det, v = glm::dot(d, q) / det, t = glm::dot(e2, q) / det;
    const double inside = std::min({u, v, 1.0 - u - v});
    if (t > -1e-4) best.margin = std::min(best.margin, std::abs(inside));
    if (inside < 0.0 || t <= 0.0) continue;
    if (t < best.t) {
      best.second = best.t;
      best.t = t;
      best.primitive = static_cast<std::uint32_t>(i);
    } else {
      best.second = std::min(best.second, t);
    }
  }
  return best;
}

TEST_F(DeviceTrace, NearestHitsAgreeWithDoublePrecision) {
  Random random(22);
  glm::dvec3 middle{};
  const TriangleMesh mesh = soup(400, [&](std::size_t, int corner) {
    if (corner == 0) middle = random.point(1.0f);
    return middle + 0.3 * glm::dvec3(random.point(1.0f));
  });
  const Scene scene = with_bodies({Body{mesh, diffuse(0.5)}});
  const Normalization norm = find_normalization(scene);
  std::vector<glm::dvec3> corners;
  for (const glm::dvec3& p : mesh.positions) corners.emplace_back(norm.point(p));
  constexpr int kRays = 8192;
  std::vector<gpu::RayCase> rays;
  rays.reserve(kRays);
  for (int i = 0; i < kRays; ++i)
    rays.push_back(ray_between(norm, glm::dvec3(random.point(1.5f)), glm::dvec3(random.point(1.0f))));
  const auto answers = trace(compile_scene(scene), rays);
  std::size_t judged = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Nearest n = nearest(corners, rays[i]);
    if (n.margin < 1e-4 || n.second - n.t < 1e-4 || n.t < 1e-4) continue;  // too close to call in single precision
    ++judged;
    ASSERT_EQ(answers[i].primitive, n.primitive) << i;
    if (n.primitive != gpu::kNone) {
      EXPECT_NEAR(answers[i].t, n.t, 1e-4);
    }
  }
  EXPECT_GT(judged, rays.size() / 2);
}

// Way through a sphere from `depth` below its surface, at the cosine c to the inward normal.
double offset_chord(double radius, double c, double depth) {
  const double inner = radius - depth;
  return inner * c + std::sqrt(radius * radius - inner * inner * (1.0 - c * c));
}

TEST_F(DeviceTrace, ClosedSurfacesDoNotLeak) {
  // A closed cube of many axis-aligned cells, so that edges lie in the faces of boxes, with rays aimed exactly at edges
  // and vertices.
  constexpr int kCells = 24;
  TriangleMesh mesh;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const double side = face % 2 == 0 ? -1.0 : 1.0;
    const auto base = static_cast<std::uint32_t>(mesh.positions.size());
    for (int y = 0; y <= kCells; ++y) {
      for (int x = 0; x <= kCells; ++x) {
        glm::dvec3 p;
        p[axis] = side;
        p[(axis + 1) % 3] = -1.0 + 2.0 * x / kCells;
        p[(axis + 2) % 3] = -1.0 + 2.0 * y / kCells;
        mesh.positions.push_back(p);
        const std::uint32_t i = base + static_cast<std::uint32_t>(y * (kCells + 1) + x);
        if (x < kCells && y < kCells)
          mesh.triangles.insert(mesh.triangles.end(),
                                {{i, i + 1, i + kCells + 2}, {i, i + kCells + 2, i + kCells + 1}});
      }
    }
  }
  for (const glm::dvec3& offset : {glm::dvec3(0.0), glm::dvec3(0.1234567, -7.654321, 3.3)}) {
    TriangleMesh moved = mesh;
    for (glm::dvec3& p : moved.positions.edit()) p += offset;
    const Scene scene =
        with_bodies({Body{moved, diffuse(0.5)}, Body{Sphere{offset + glm::dvec3(5.0, 0.0, 0.0), 0.5}, diffuse(0.5)}});
    const Normalization norm = find_normalization(scene);
    Random random(24);
    std::vector<gpu::RayCase> rays;
    for (int i = 0; i < 1 << 16; ++i) {
      const glm::uvec3 t = mesh.triangles[random.below(static_cast<std::uint32_t>(mesh.triangles.size()))];
      const double along = i % 3 == 0 ? 0.0 : static_cast<double>(random.unit());
      const glm::dvec3 target = glm::mix(moved.positions[t[i % 3]], moved.positions[t[(i + 1) % 3]], along);
      rays.push_back(ray_between(norm, offset + (i % 5 == 0 ? 0.999 : 0.5) * glm::dvec3(random.point(1.0f)), target));
    }
    const CompiledScene compiled = compile_scene(scene);
    std::vector<gpu::SpawnCase> cases;
    cases.reserve(rays.size());
    for (const gpu::RayCase& r : rays) cases.push_back({r.o, 0, r.d, 0, -r.d, 0});
    std::size_t leaks = 0;
    for (const auto& a : run<gpu::SpawnAnswer>({kernels::spawns, "spawns", &compiled, {}}, cases))
      leaks += a.instance != 0;
    EXPECT_EQ(leaks, 0u) << "of " << rays.size() << " rays";
  }
}

class SpawnScene {
 public:
  SpawnScene(double scale, const glm::dvec3& offset) {
    TriangleMesh room = box({-1, -1, -1}, {1, 1, 1}, true);
    for (glm::dvec3& p : room.positions.edit()) p = p * scale + offset;
    reference::test::add(scene_, room, diffuse(0.5));
    reference::test::add(scene_, Sphere{glm::dvec3(0.3, -0.4, 0.2) * scale + offset, 0.25 * scale}, diffuse(0.5));
    normalization_ = find_normalization(scene_);
    center_ = offset;
    scale_ = scale;
  }
  const Scene& scene() const { return scene_; }
  glm::vec3 inside(Random& random) const {
    return normalization_.point(center_ + scale_ * 0.99 * glm::dvec3(random.point(1.0f)));
  }
  glm::dvec3 sphere_center() const { return normalization_.point(std::get<Sphere>(scene_.shapes[1]).center); }
  double sphere_radius() const { return 0.25 * scale_ * normalization_.scale; }

 private:
  Scene scene_;
  Normalization normalization_;
  glm::dvec3 center_;
  double scale_;
};

TEST_F(DeviceTrace, RaysLeaveSurfacesWithoutMeetingThemAgain) {
  struct Place {
    double scale;
    glm::dvec3 offset;
  };
  for (const Place& place :
       {Place{1.0, {0, 0, 0}}, Place{1e-3, {0, 0, 0}}, Place{1e4, {0, 0, 0}}, Place{1.0, {1e6, -2e6, 3e5}}}) {
    const SpawnScene s(place.scale, place.offset);
    Random random(23);
    std::vector<gpu::SpawnCase> cases;
    for (int i = 0; i < 1 << 15; ++i) {
      const glm::vec3 o = s.inside(random), d(random.direction());
      cases.push_back({o, 0, d, 0, glm::vec3(random.direction()), 0});
    }
    const CompiledScene compiled = compile_scene(s.scene());
    const auto answers = run<gpu::SpawnAnswer>({kernels::spawns, "spawns", &compiled, {}}, cases);
    std::size_t walls = 0, outside = 0, inside = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const gpu::SpawnAnswer& a = answers[i];
      ASSERT_NE(a.instance, gpu::kNone) << "the room is closed";
      const double cosine = glm::dot(glm::dvec3(a.ng), glm::dvec3(cases[i].wi));
      if (a.instance == 0) {  // a wall: inward the next hit is another wall or the sphere, outward there is nothing
        EXPECT_EQ(a.next_instance == gpu::kNone, cosine < 0.0) << i << ' ' << cosine;
        if (a.next_instance == 0) {
          EXPECT_NE(a.next_primitive / 2, a.primitive / 2) << i << ' ' << cosine;
        }
        ++walls;
      } else if (cosine > 0.0) {
        EXPECT_EQ(a.next_instance, 0u) << "a sphere is convex; cosine " << cosine;
        ++outside;
      } else {  // through the sphere: the chord is 2 r |cos|
        const double chord = 2.0 * s.sphere_radius() * -cosine;
        if (chord > 4.0 * a.error) {
          EXPECT_EQ(a.next_instance, 1u) << cosine;
          EXPECT_NEAR(a.t, offset_chord(s.sphere_radius(), -cosine, a.error), 2e-6 + 2e-6 * s.sphere_radius() / chord)
              << cosine;
        }
        ++inside;
      }
      if (a.instance == 1) {
        EXPECT_NEAR(glm::length(glm::dvec3(a.p) - s.sphere_center()), s.sphere_radius(), a.error);
      }
    }
    EXPECT_GT(std::min({walls, outside, inside}), 100u);
  }
}

}  // namespace
}  // namespace etendue::test
