/// The tree as rays see it, on the host: adversarial meshes, closed surfaces, and the work a ray takes.

#include <algorithm>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "compile/few_primitives.h"
#include "compile/reinsertion.h"
#include "core/parallel.h"
#include "host_walk.h"
#include "tree_widths.h"

namespace etendue::test {
namespace {

using Mesh = std::vector<gpu::Primitive>;

Box box_of(const gpu::Primitive& p) {
  Box box;
  for (const glm::vec3& v : {p.p0, p.p1, p.p2}) box.extend(v);
  return box;
}
template <std::uint32_t width>
WideBvh tree_of(const Mesh& mesh) {
  std::vector<Box> boxes;
  for (const gpu::Primitive& p : mesh) boxes.push_back(box_of(p));
  Bvh bvh = build_bvh(std::move(boxes));
  reinsert_subtrees(bvh);
  return make_wide_bvh<width>(bvh, mesh);
}

template <typename Width>
class CompileWalk : public ::testing::Test {};
TYPED_TEST_SUITE(CompileWalk, TreeWidths, TreeWidthNames);

class RandomPoints {
 public:
  explicit RandomPoints(unsigned seed) : engine_(seed) {}
  float operator()(float low, float high) { return std::uniform_real_distribution<float>(low, high)(engine_); }
  glm::vec3 point(float half) {
    const float x = (*this)(-half, half), y = (*this)(-half, half);
    return {x, y, (*this)(-half, half)};
  }
  std::size_t below(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(engine_); }

 private:
  std::mt19937 engine_;
};

HostRay ray_to(const glm::vec3& from, const glm::vec3& to) {
  return {from, 0.0f, glm::normalize(to - from), INFINITY};
}

Mesh make_mesh(std::size_t count, const std::function<void(std::size_t, gpu::Primitive&)>& vertices) {
  Mesh mesh(count);
  for (std::size_t i = 0; i < count; ++i) vertices(i, mesh[i]);
  return mesh;
}

struct Adversary {
  const char* name;
  Mesh mesh;
  double least_hits;
};
std::vector<Adversary> adversaries() {
  RandomPoints random(1);
  std::vector<Adversary> out;
  out.push_back({"one triangle 20 000 times",
                 make_mesh(20000,
                           [](std::size_t, gpu::Primitive& p) {
                             p.p0 = {-1, -1, 0}, p.p1 = {1, -1, 0.1f}, p.p2 = {0, 1, 0};
                           }),
                 0.05});
  out.push_back({"exponentially shrinking",
                 make_mesh(3000,
                           [&](std::size_t i, gpu::Primitive& p) {
                             const float s = std::exp2(-0.04f * static_cast<float>(i));
                             p.p0 = s * glm::vec3(1, 0, 0), p.p1 = s * glm::vec3(0, 1, 0),
                             p.p2 = s * glm::vec3(0, 0, 1);
                           }),
                 0.05});
  out.push_back({"long slivers",
                 make_mesh(20000,
                           [&](std::size_t, gpu::Primitive& p) {
                             p.p0 = random.point(1.0f), p.p1 = random.point(1.0f), p.p2 = p.p1 + random.point(1e-3f);
                           }),
                 0.05});
  out.push_back({"coplanar",
                 make_mesh(100000,
                           [&](std::size_t, gpu::Primitive& p) {
                             p.p0 = random.point(1.0f), p.p1 = p.p0 + random.point(0.02f),
                             p.p2 = p.p0 + random.point(0.02f);
                             p.p0.y = p.p1.y = p.p2.y = 0.0f;
                           }),
                 0.05});
  out.push_back({"all centres on one point",
                 make_mesh(5000,
                           [&](std::size_t i, gpu::Primitive& p) {
                             const float s = 0.1f + 0.0001f * static_cast<float>(i);
                             p.p0 = {-s, -s, -s}, p.p1 = {s, s, -s}, p.p2 = {-s, s, s};
                           }),
                 0.05});
  return out;
}

// The walk finds what testing every primitive finds, to the bit; where several lie at that distance, any of them. The
// loop also asks about triangles far off the ray, where rounding alone may call a sliver hit whose box the ray misses:
// `unclear` bounds their share.
TYPED_TEST(CompileWalk, AdversarialMeshesAreHitAsByBruteForce) {
  for (const Adversary& a : adversaries()) {
    SCOPED_TRACE(a.name);
    const WideBvh tree = tree_of<TypeParam::value>(a.mesh);
    EXPECT_LE(tree.depth, gpu::kMaxTreeDepth);
    RandomPoints random(2);
    Visits visits;
    int hits = 0, unclear = 0;
    constexpr int kRays = 400;
    for (int i = 0; i < kRays; ++i) {
      const gpu::Primitive& target = a.mesh[random.below(a.mesh.size())];
      const glm::vec3 inside = (target.p0 + target.p1 + target.p2) / 3.0f;
      const HostRay ray = ray_to(random.point(1.5f), i % 2 == 0 ? inside : random.point(0.8f));
      const HostHit brute = host_brute_force(tree, a.mesh, ray),
                    walked = host_walk<TypeParam::value>(tree, ray, false, visits);
      hits += brute.slot != gpu::kNone;
      unclear += brute.t != walked.t;
      EXPECT_GE(walked.t, brute.t) << "the walk found what does not exist";
      EXPECT_EQ(host_walk<TypeParam::value>(tree, ray, true, visits).slot != gpu::kNone, walked.slot != gpu::kNone);
    }
    EXPECT_GE(hits, a.least_hits * kRays) << "the test hardly tests";
    EXPECT_LE(unclear, 0.01 * kRays);
  }
}

TYPED_TEST(CompileWalk, ManyEqualOrCoplanarTrianglesMakeAShallowTree) {
  RandomPoints random(3);
  const Mesh equal = make_mesh(300000, [](std::size_t, gpu::Primitive& p) {
    p.p0 = {0, 0, 0}, p.p1 = {1, 0, 0}, p.p2 = {0, 1, 0};
  });
  const Mesh points = make_mesh(300000, [](std::size_t, gpu::Primitive& p) {
    p.p0 = p.p1 = p.p2 = {0.5f, 0.5f, 0.5f};
  });
  const Mesh flat = make_mesh(300000, [&](std::size_t, gpu::Primitive& p) {
    p.p0 = random.point(1.0f), p.p1 = p.p0 + random.point(1e-3f), p.p2 = p.p0 + random.point(1e-3f);
    p.p0.z = p.p1.z = p.p2.z = 0.25f;
  });
  for (const Mesh* mesh : {&equal, &points, &flat}) EXPECT_LE(tree_of<TypeParam::value>(*mesh).depth, 20u);
}

// A bumpy closed surface around the origin: `rows` of quads from pole to pole, cut into triangles.
Mesh closed_surface(std::uint32_t rows) {
  const std::uint32_t columns = 2 * rows;
  const auto vertex = [&](std::uint32_t row, std::uint32_t column) {
    if (row == 0 || row == rows) column = 0;  // the poles are single points
    const double theta = 3.14159265358979 * row / rows, phi = 6.28318530717959 * (column % columns) / columns;
    const double radius = 0.7 + 0.05 * std::sin(9.0 * theta) * std::cos(7.0 * phi) * std::sin(theta);
    return glm::vec3(radius *
                     glm::dvec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)));
  };
  Mesh mesh;
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const glm::vec3 a = vertex(row, column), b = vertex(row + 1, column), c = vertex(row + 1, column + 1),
                      d = vertex(row, column + 1);
      gpu::Primitive p{};
      p.p0 = a, p.p1 = b, p.p2 = c;
      if (row + 1 < rows) mesh.push_back(p);
      p.p1 = c, p.p2 = d;
      if (row > 0) mesh.push_back(p);
    }
  }
  return mesh;
}

// ETENDUE_LEAK_RAYS raises the number of rays; docs/bvh.md holds the count of a long run.
std::size_t leak_rays() {
  const char* wanted = std::getenv("ETENDUE_LEAK_RAYS");
  return wanted != nullptr ? std::stoull(wanted) : 300000;
}

TYPED_TEST(CompileWalk, AClosedMeshLeaksNoRay) {
  const Mesh mesh = closed_surface(96);
  const WideBvh tree = tree_of<TypeParam::value>(mesh);
  constexpr std::size_t kChunk = 10000;
  std::vector<std::size_t> leaks(leak_rays() / kChunk, 0);
  parallel_for(leaks.size(), 1, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t chunk = begin; chunk < end; ++chunk) {
      RandomPoints random(static_cast<unsigned>(chunk) + 7);
      Visits visits;
      for (std::size_t i = 0; i < kChunk; ++i) {
        // At a vertex, at a point of an edge, anywhere.
        const gpu::Primitive& p = mesh[random.below(mesh.size())];
        const float along = i % 4 == 0 ? 0.0f : random(0.0f, 1.0f);
        const glm::vec3 target = i % 4 == 3 ? random.point(1.0f) : p.p0 + along * (p.p1 - p.p0);
        const glm::vec3 from = random.point(0.3f);
        if (target == from) continue;
        leaks[chunk] += host_walk<TypeParam::value>(tree, ray_to(from, target), i % 2 == 0, visits).slot == gpu::kNone;
      }
    }
  });
  std::size_t total = 0;
  for (const std::size_t n : leaks) total += n;
  EXPECT_EQ(total, 0u) << "of " << leaks.size() * kChunk << " rays";
}

// A room of twelve triangles around the closed surface: what the renderer's scenes look like. Bounds on the work of a
// ray, with room of a tenth: a change of the builder that costs more has to say why.
TYPED_TEST(CompileWalk, WorkOfARayStaysLow) {
  Mesh mesh = closed_surface(160);
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 corner[4];
      for (int k = 0; k < 4; ++k) {
        corner[k][axis] = side;
        corner[k][(axis + 1) % 3] = k == 1 || k == 2 ? 1.0f : -1.0f;
        corner[k][(axis + 2) % 3] = k >= 2 ? 1.0f : -1.0f;
      }
      gpu::Primitive p{};
      p.p0 = corner[0], p.p1 = corner[1], p.p2 = corner[2];
      mesh.push_back(p);
      p.p1 = corner[2], p.p2 = corner[3];
      mesh.push_back(p);
    }
  }
  std::vector<Box> boxes;
  for (const gpu::Primitive& p : mesh) boxes.push_back(box_of(p));
  const std::vector<std::uint32_t> few = choose_few_primitives(boxes);
  EXPECT_EQ(few.size(), 12u);
  Bvh bvh = build_bvh(boxes, few);
  reinsert_subtrees(bvh);
  const WideBvh tree = make_wide_bvh<TypeParam::value>(bvh, mesh, few);
  RandomPoints random(5);
  Visits visits;
  constexpr int kRays = 20000;
  for (int i = 0; i < kRays; ++i) {
    const HostRay ray = ray_to(random.point(1.0f), random.point(1.0f));
    host_walk<TypeParam::value>(tree, ray, false, visits);
  }
  this->RecordProperty("nodes_per_1000_rays", static_cast<int>(visits.nodes / (kRays / 1000)));
  this->RecordProperty("primitives_per_1000_rays", static_cast<int>(visits.primitives / (kRays / 1000)));
  EXPECT_LE(static_cast<double>(visits.nodes) / kRays, TypeParam::value == 8 ? 9.9 : 13.6);
  EXPECT_LE(static_cast<double>(visits.primitives) / kRays, 2.5);
}

}  // namespace
}  // namespace etendue::test
