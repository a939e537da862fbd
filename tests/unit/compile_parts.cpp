/// Thresholds, filter tables, normalisation and what compile_scene makes of shapes and lights.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "compile/compiled_scene.h"
#include "compile/compiled_view.h"
#include "compile/discrete.h"
#include "compile/filter_table.h"
#include "compile/normalization.h"
#include "compile/vertex_normals.h"

namespace etendue {
namespace {

constexpr std::uint64_t kOne = std::uint64_t{1} << 32;

TEST(CompileDiscrete, KnownThresholds) {
  using T = std::vector<std::uint64_t>;
  EXPECT_EQ(integer_thresholds(std::vector{1.0}), (T{0, kOne}));
  EXPECT_EQ(integer_thresholds(std::vector{1.0, 1.0}), (T{0, kOne / 2, kOne}));
  EXPECT_EQ(integer_thresholds(std::vector{1.0, 2.0, 1.0}), (T{0, kOne / 4, kOne / 4 * 3, kOne}));
  EXPECT_EQ(integer_thresholds(std::vector{0.0, 3.0, 0.0}), (T{0, 0, kOne, kOne}));
  EXPECT_EQ(integer_thresholds(std::vector{1.0, 1.0, 1.0}), (T{0, kOne / 3, kOne * 2 / 3, kOne}));  // floor(2^32/3)
  EXPECT_TRUE(integer_thresholds(std::vector{0.0, 0.0}).empty());
  EXPECT_TRUE(integer_thresholds(std::vector<double>{}).empty());
}

TEST(CompileDiscrete, TinyWeightsGetOneUnit) {
  const std::vector weights = {1e-30, 1.0, 1e-30, 0.0, 1e30, 1e-30, 1e-300};
  const auto t = integer_thresholds(weights);
  ASSERT_EQ(t.size(), weights.size() + 1);
  EXPECT_EQ(t.front(), 0u);
  EXPECT_EQ(t.back(), kOne);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0.0) {
      EXPECT_GT(t[i + 1], t[i]) << i;
    } else {
      EXPECT_EQ(t[i + 1], t[i]) << i;
    }
  }
  EXPECT_EQ(t[7] - t[6], 1u);
  EXPECT_EQ(t[1] - t[0], 1u);
}

TEST(CompileDiscrete, ProbabilitiesAreTheWeightsToOneUnit) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (const std::size_t n : {2u, 10u, 1000u, 100000u}) {
    std::vector<double> weights;
    double total = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      weights.push_back(i % 7 == 3 ? 0.0 : 0.05 + u(random));
      total += weights.back();
    }
    const auto t = integer_thresholds(weights);
    for (std::size_t i = 0; i < n; ++i) {
      const double prob = static_cast<double>(t[i + 1] - t[i]) * 0x1p-32;
      ASSERT_NEAR(prob, weights[i] / total, 0x1.1p-32) << i;
    }
  }
}

// The walk down a search tree, with what it does not know about thresholds it has not looked at.
std::uint32_t found_in(const std::vector<gpu::uvec4>& nodes, std::uint32_t count, std::uint32_t word) {
  std::uint32_t span = 1, found = 0, first = 0;
  while (span < count) span *= gpu::kSearchFan;
  while (span > 1) {
    const gpu::uvec4 node = nodes.at(first + found);
    first += (count + span - 1) / span;
    span /= gpu::kSearchFan;
    found *= gpu::kSearchFan;
    for (int i = 0; i < 4; ++i) found += node[i] <= word ? 1 : 0;
    found = std::min(found, (count - 1) / span);
  }
  return found;
}

TEST(CompileDiscrete, SearchTreesFindWhatTheThresholdsSay) {
  std::mt19937_64 random(11);
  for (const std::uint32_t count : {1u, 2u, 4u, 5u, 6u, 24u, 25u, 26u, 125u, 130u, 777u}) {
    std::vector<double> weights(count);
    for (double& w : weights) w = random() % 3 == 0 ? 0.0 : std::exp2(static_cast<double>(random() % 24));
    weights[count / 2] = 1e12;
    if (count > 6) weights.back() = 1e-20;
    const auto thresholds = integer_thresholds(weights);
    std::vector<gpu::uvec4> nodes(SearchTree(count).nodes);
    write_search_tree(std::span(thresholds).first(count), nodes);
    std::vector<std::uint64_t> words = {0, 1, kOne - 2, kOne - 1};
    for (const std::uint64_t t : thresholds) words.insert(words.end(), {t - (t > 0 ? 1 : 0), t});
    for (int i = 0; i < 1000; ++i) words.push_back(random() % kOne);
    for (const std::uint64_t word : words) {
      if (word == kOne) continue;
      const auto entry = std::ranges::upper_bound(thresholds, word) - thresholds.begin() - 1;
      // Entries without weight at the end cannot be told from what is not there: whoever asks knows the last that has.
      std::uint32_t last = count - 1;
      while (!(weights[last] > 0.0)) --last;
      ASSERT_EQ(std::min(found_in(nodes, count, static_cast<std::uint32_t>(word)), last), entry)
          << count << " " << word;
    }
  }
}

// ∫ of |f| or f over [a, b] by Simpson's rule on the published formulas.
double filter_value(const ReconstructionFilter& f, double x) {
  x = std::abs(x);
  if (f.type == ReconstructionFilter::Type::tent) return std::max(0.0, 1.0 - x / f.stretch);
  if (f.type == ReconstructionFilter::Type::box) return 1.0;
  if (f.type == ReconstructionFilter::Type::lanczos) {
    const auto sinc = [](double t) { return t == 0.0 ? 1.0 : std::sin(t) / t; };
    return sinc(std::numbers::pi * x) * sinc(std::numbers::pi * x / f.lobes);
  }
  if (f.type == ReconstructionFilter::Type::gaussian) {
    const double s2 = 2.0 * f.stddev * f.stddev;
    return x < f.radius ? std::exp(-x * x / s2) - std::exp(-f.radius * f.radius / s2) : 0.0;
  }
  const double q = 2.0 * x / f.radius, b = f.b, c = f.c;
  if (q < 1) return ((12 - 9 * b - 6 * c) * q * q * q + (-18 + 12 * b + 6 * c) * q * q + 6 - 2 * b) / 6.0;
  if (q < 2)
    return ((-b - 6 * c) * q * q * q + (6 * b + 30 * c) * q * q + (-12 * b - 48 * c) * q + 8 * b + 24 * c) / 6.0;
  return 0.0;
}
double integral(const ReconstructionFilter& f, double a, double b, bool absolute) {
  constexpr int kSteps = 4000;
  double sum = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const double v = filter_value(f, a + (b - a) * i / kSteps);
    sum += (i == 0 || i == kSteps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) * (absolute ? std::abs(v) : v);
  }
  return sum * (b - a) / (3.0 * kSteps);
}

TEST(CompileFilter, KnotsAreTheInverseOfTheCumulativeFilter) {
  using Type = ReconstructionFilter::Type;
  EXPECT_TRUE(make_filter_table({}).knots.empty()) << "the box needs no table";
  for (const ReconstructionFilter& f :
       {ReconstructionFilter{.type = Type::tent, .radius = 1.0}, ReconstructionFilter{.type = Type::gaussian},
        ReconstructionFilter{.type = Type::mitchell}, ReconstructionFilter{.type = Type::mitchell, .radius = 4.0},
        ReconstructionFilter{.type = Type::mitchell, .b = 1.0, .c = 0.0},
        ReconstructionFilter{.type = Type::tent, .radius = 2.5, .stretch = 2.5},
        ReconstructionFilter{.type = Type::box, .radius = 1.5, .stretch = 3.0},
        ReconstructionFilter{.type = Type::lanczos, .radius = 3.0},
        ReconstructionFilter{.type = Type::lanczos, .radius = 2.0, .lobes = 2}}) {
    const FilterTable table = make_filter_table(f);
    ASSERT_EQ(table.knots.size(), gpu::kFilterSteps + 1);
    EXPECT_EQ(table.knots.front(), static_cast<float>(-f.radius));
    EXPECT_EQ(table.knots.back(), static_cast<float>(f.radius));
    EXPECT_NEAR(table.knots[512], 0.0f, 1e-4f);
    const double total = integral(f, -f.radius, 0.0, true) + integral(f, 0.0, f.radius, true);
    const double net = integral(f, -f.radius, 0.0, false) + integral(f, 0.0, f.radius, false);
    EXPECT_NEAR(table.weight, total / net, 1e-6);
    for (const std::size_t i : {1u, 100u, 300u, 511u, 700u, 1000u, 1023u}) {
      EXPECT_NEAR(integral(f, -f.radius, table.knots[i], true) / total, static_cast<double>(i) / 1024.0, 2e-6) << i;
      EXPECT_LT(table.knots[i - 1], table.knots[i]);
    }
    EXPECT_EQ(table.alternates, f.type == Type::lanczos);
    const bool turns = f.type == Type::mitchell && f.c > 0.0;  // once, where Lanczos's turns at every whole number
    EXPECT_EQ(table.turns_negative, turns);
    if (turns) {
      EXPECT_GT(filter_value(f, table.zero * 0.999), 0.0);
      EXPECT_LT(filter_value(f, table.zero * 1.001), 0.0);
    }
  }
}

void add(Scene& scene, Shape shape, double radiance) {
  scene.add(std::move(shape), DiffuseBsdf{},
            radiance > 0.0 ? std::optional(AreaEmitter{glm::dvec3(radiance)}) : std::nullopt);
}
void add_sphere(Scene& scene, const glm::dvec3& center, double radius, double radiance = 0.0) {
  add(scene, Sphere{center, radius}, radiance);
}
void add_triangle(Scene& scene, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double radiance = 0.0) {
  add(scene, TriangleMesh{.positions = {a, b, c}, .normals = {}, .triangles = {{0, 1, 2}}}, radiance);
}

TEST(CompileNormalization, ScalesByPowersOfTwoIntoTheUnitCube) {
  for (const double scale : {1e-6, 1e-3, 1.0, 3.7, 1e4, 1e8}) {
    for (const glm::dvec3& offset : {glm::dvec3(0.0), glm::dvec3(1e5, -3.0, 1e-4)}) {
      Scene scene;
      add_sphere(scene, offset + scale * glm::dvec3(1, 2, 3), scale);
      add_triangle(scene, offset, offset + scale * glm::dvec3(0, 5, 1), offset - scale);
      const Normalization n = find_normalization(scene);
      int exponent = 0;
      EXPECT_EQ(std::frexp(n.scale, &exponent), 0.5) << "a power of two";
      double farthest = 0.0;
      const auto reach = [&](const glm::dvec3& p) {
        const glm::dvec3 q = glm::abs(glm::dvec3(n.point(p)));
        farthest = std::max({farthest, q.x, q.y, q.z});
      };
      reach(offset + scale * glm::dvec3(2, 3, 4)), reach(offset + scale * glm::dvec3(0, 1, 2));
      reach(offset), reach(offset + scale * glm::dvec3(0, 5, 1)), reach(offset - scale);
      EXPECT_LE(farthest, 1.0 + 1e-6);
      EXPECT_GE(farthest, 0.5 - 1e-6);
      EXPECT_EQ(n.point(n.center), glm::vec3(0.0f));
    }
  }
}

TEST(CompileNormalization, EmptyScenesStayWhereTheyAre) {
  const Normalization n = find_normalization(Scene{});
  EXPECT_EQ(n.scale, 1.0);
  EXPECT_EQ(n.point({1, 2, 3}), glm::vec3(1, 2, 3));
}

TEST(CompileNormalization, AGroundSphereDoesNotPullTheCentreAway) {
  Scene scene;
  add_sphere(scene, {0, -1000, 0}, 1000);
  for (int i = 0; i < 10; ++i) add_sphere(scene, {i, 0.5, 0}, 0.5);
  EXPECT_LT(glm::length(find_normalization(scene).center), 10.0);
}

TEST(CompileScene, EmptySceneHasBindableBuffers) {
  const CompiledScene c = compile_scene(Scene{});
  EXPECT_FALSE(c.records.empty());
  EXPECT_FALSE(c.instances.empty());
  EXPECT_EQ(SceneFacts(c).light_instance_count, 0u);
}

TEST(CompileScene, LightsCarryTheirProbabilities) {
  Scene scene;
  add_sphere(scene, {0, 0, 0}, 1.0);
  add_triangle(scene, {0, 0, 0}, {2, 0, 0}, {0, 2, 0}, 3.0);
  add_sphere(scene, {5, 0, 0}, 0.5, 1.0);
  add_triangle(scene, {1, 1, 1}, {2, 1, 1}, {1, 2, 2}, 0.0);  // dark
  const CompiledScene c = compile_scene(scene);
  ASSERT_EQ(c.light_instances.size(), 2u);
  EXPECT_EQ(SceneFacts(c).light_instance_count, 2u);
  const double triangle_power = 3.0 * 2.0, sphere_power = std::numbers::pi;
  EXPECT_EQ(c.light_instances[0].instance, 1u);
  EXPECT_EQ(c.light_instances[1].instance, 2u);
  EXPECT_EQ(c.light_instances[0].threshold, 0u);
  EXPECT_NEAR(c.light_instances[1].threshold * 0x1p-32, triangle_power / (triangle_power + sphere_power), 1e-9);
  EXPECT_NEAR(c.instances[1].light_prob, triangle_power / (triangle_power + sphere_power), 1e-7);
  EXPECT_NEAR(c.instances[2].light_prob, sphere_power / (triangle_power + sphere_power), 1e-7);
  EXPECT_EQ(c.instances[0].light_prob, 0.0f);
  EXPECT_EQ(c.instances[3].light_prob, 0.0f);
  const double scale = find_normalization(scene).scale;
  EXPECT_NEAR(c.instances[1].light_area, 2.0 * scale * scale, 1e-7);
}

TEST(CompileScene, VertexNormalsOfAllMeshesFollowEachOther) {
  Scene scene;
  for (int i = 0; i < 3; ++i) {
    add_triangle(scene, {i, 0, 0}, {i + 1, 0, 0}, {i, 1, 0});
    if (i != 1)
      std::get<TriangleMesh>(scene.shapes.back()).normals = {{0, 0, 1}, {0, 1, 0}, glm::normalize(glm::dvec3(i, 1, 1))};
  }
  const CompiledScene c = compile_scene(scene);
  EXPECT_EQ(c.instances[0].first_triangle, 0u);
  EXPECT_EQ(c.instances[1].first_triangle, gpu::kNone);
  EXPECT_EQ(c.instances[2].first_triangle, 1u);
  ASSERT_EQ(c.vertex_normals.size(), 2u);
  const glm::dvec3 last = glm::normalize(glm::dvec3(2, 1, 1));
  EXPECT_EQ(c.vertex_normals[1], pack_normals({0, 0, 1}, {0, 1, 0}, last));
}

}  // namespace
}  // namespace etendue
