/// Light sampling: the choice among lights, points and densities on triangles and spheres, and its agreement with what
/// emission met by chance is weighed with.

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "compile/discrete.h"
#include "compile/normalization.h"
#include "device_test.h"
#include "reference/lights.h"
#include "reference_scenes.h"
#include "scene/placed.h"
#include "validate/statistics.h"

namespace etendue::test {
namespace {

using reference::test::Body;
using reference::test::diffuse;
using reference::test::quad;
using reference::test::triangle;

constexpr double kPi = std::numbers::pi;

class DeviceEmitter : public DeviceTest {
 protected:
  std::vector<gpu::LightAnswer> sample(const CompiledScene& scene, const std::vector<gpu::LightCase>& cases) {
    return run<gpu::LightAnswer>({kernels::light_samples, "light_samples", &scene, {}}, cases);
  }
  std::vector<gpu::EmissionAnswer> emission(const CompiledScene& scene, const std::vector<gpu::RayCase>& rays) {
    const CompiledScene listed = list_primitives(scene);
    return run<gpu::EmissionAnswer>({kernels::emissions, "emissions", &listed, {}}, rays);
  }
};

// A scene of these bodies and one receiver far from mattering, with the map into its device coordinates.
struct LightScene {
  explicit LightScene(const std::vector<Body>& bodies,
                      Integrator::LightSampler light_sampler = Integrator::LightSampler::power) {
    for (const Body& body : bodies) reference::test::add(scene, body);
    compile(light_sampler);
  }
  LightScene(Scene whole, Integrator::LightSampler light_sampler) : scene(std::move(whole)) { compile(light_sampler); }

  void compile(Integrator::LightSampler light_sampler) {
    scene.integrator.light_sampler = light_sampler;
    compiled = compile_scene(scene);
    normalization = find_normalization(scene);
  }
  Scene scene;
  CompiledScene compiled;
  Normalization normalization;
};

std::vector<gpu::LightCase> random_cases(const glm::vec3& p, std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<gpu::LightCase> cases;
  for (std::size_t i = 0; i < n; ++i) {
    const gpu::uint a = random.word(), b = random.word(), c = random.word();
    cases.push_back({p, 0, {a, b, c, random.word()}, glm::vec3(0.0f), 0});
  }
  return cases;
}

TEST_F(DeviceEmitter, SphereIsSampledByTheConeItFills) {
  const Sphere sphere{.center = {1.0, -2.0, 0.5}, .radius = 0.75};
  const LightScene setup({Body{sphere, diffuse(0.5), glm::dvec3(3.0)}});
  const glm::dvec3 center = setup.normalization.point(sphere.center);
  const double radius = sphere.radius * setup.normalization.scale;
  const glm::dvec3 toward = glm::normalize(glm::dvec3(0.3, 0.8, -0.5));
  for (const double distance : {1.0001, 1.01, 1.5, 3.0, 100.0, 1e5}) {  // in radii
    const glm::vec3 p(center + toward * (distance * radius));
    const double d = glm::length(glm::dvec3(p) - center);
    const double sin2 = radius * radius / (d * d), one_minus_cos = sin2 / (1.0 + std::sqrt(1.0 - sin2));
    const auto answers = sample(setup.compiled, random_cases(p, 1 << 15, 1));
    std::vector<double> rings(32, 0.0);
    const double slack = 1e-6 / std::max(1e-2, 1.0 - radius / d);  // near the surface 1 − sin² cancels
    for (const auto& a : answers) {
      ASSERT_NEAR(a.pdf_w * (2.0 * kPi * one_minus_cos), 1.0, 10 * slack) << distance;
      EXPECT_EQ(a.mis_pdf, a.pdf_w);
      EXPECT_EQ(a.radiance, glm::vec3(3.0f));
      const glm::dvec3 on = glm::dvec3(a.p) - center;
      EXPECT_NEAR(glm::length(on), radius, 2e-6 * radius + 1e-7);
      EXPECT_LT(glm::length(glm::dvec3(a.ng) - on / glm::length(on)), 1e-5);
      EXPECT_GT(glm::dot(glm::dvec3(a.ng), -glm::dvec3(a.wi)), -2e-3);  // the nearer intersection shines this way
      EXPECT_NEAR(glm::length(glm::dvec3(a.wi)), 1.0, 1e-6);
      const glm::dvec3 across = glm::cross(glm::dvec3(a.wi), (center - glm::dvec3(p)) / d);
      const double s2 = glm::dot(across, across);
      const bool front = glm::dot(glm::dvec3(a.wi), center - glm::dvec3(p)) > 0.0;
      const double w = front ? s2 / (1.0 + std::sqrt(std::max(0.0, 1.0 - s2))) : 1.0;
      ++rings[std::clamp(static_cast<int>(32.0 * w / one_minus_cos), 0, 31)];
    }
    if (distance < 1e4) {
      EXPECT_GT(uniformity(rings), kSmallestP) << distance;  // far away float32 directions are coarser than the rings
    }
  }
}

TEST_F(DeviceEmitter, SphereSendsNothingInside) {
  const Sphere sphere{.center = {0.0, 0.0, 0.0}, .radius = 2.0};
  const LightScene setup({Body{sphere, diffuse(0.5), glm::dvec3(1.0)}});
  Random random(2);
  for (const double r : {0.0, 0.5, 1.9, 1.9999}) {
    const glm::vec3 p = setup.normalization.point(random.direction() * r);
    for (const auto& a : sample(setup.compiled, random_cases(p, 256, 3))) {
      EXPECT_EQ(a.pdf_w, 0.0f) << r;
      EXPECT_EQ(a.mis_pdf, 0.0f) << r;
    }
  }
}

TEST_F(DeviceEmitter, TriangleIsSampledByArea) {
  const TriangleMesh mesh = triangle({-1, 2, 0.5}, {0.7, 1.8, -0.2}, {0.1, 2.5, 1.1});
  const LightScene setup({Body{mesh, diffuse(0.0), glm::dvec3(1.0, 2.0, 4.0)}});
  std::array<glm::dvec3, 3> v;
  for (int k = 0; k < 3; ++k) v[k] = setup.normalization.point(mesh.positions[k]);
  const glm::dvec3 n = glm::cross(v[1] - v[0], v[2] - v[0]);
  const double area = 0.5 * glm::length(n);
  const glm::dvec3 middle = (v[0] + v[1] + v[2]) / 3.0, ng = glm::normalize(n);
  for (const double side : {1.0, -1.0}) {
    const glm::vec3 p(middle + side * 0.4 * ng + 0.2 * glm::normalize(v[1] - v[0]));
    std::vector<double> quarters(4, 0.0);
    for (const auto& a : sample(setup.compiled, random_cases(p, 1 << 15, 4))) {
      const glm::dvec3 to_light = glm::dvec3(a.p) - glm::dvec3(p);
      const double d2 = glm::dot(to_light, to_light), cosine = -glm::dot(to_light / std::sqrt(d2), ng);
      EXPECT_NEAR(glm::dot(glm::dvec3(a.p) - v[0], ng), 0.0, 1e-6);
      EXPECT_LT(glm::length(glm::dvec3(a.wi) - to_light / std::sqrt(d2)), 1e-6);
      const double expected = side > 0 ? d2 / (area * cosine) : 0.0;
      EXPECT_NEAR(a.pdf_w, expected, 1e-4 * expected);
      EXPECT_NEAR(a.mis_pdf, expected, 1e-4 * expected);
      const glm::dvec3 q = glm::dvec3(a.p) - v[0];  // barycentric weights by areas
      const double b2 = glm::dot(glm::cross(v[1] - v[0], q), ng) / (2 * area),
                   b1 = glm::dot(glm::cross(q, v[2] - v[0]), ng) / (2 * area);
      ++quarters[b1 > 0.5 ? 0 : b2 > 0.5 ? 1 : b1 + b2 < 0.5 ? 2 : 3];
    }
    EXPECT_GT(uniformity(quarters), kSmallestP);
  }
}

// Lights of mixed shape around the origin, disjoint as seen from it: every second a sphere.
std::vector<Body> ring_of_lights(int count) {
  std::vector<Body> bodies;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * i / count, room = 2.0 * std::sin(kPi / std::max(3, count));
    const glm::dvec3 center(2.0 * std::cos(angle), 0.2 * (i % 3), 2.0 * std::sin(angle));
    const glm::dvec3 radiance(0.5 + i % 7, 1.0, 0.1 * i);
    if (i % 2 == 1) {
      bodies.push_back(Body{Sphere{.center = center, .radius = 0.4 * room}, diffuse(0.5), radiance});
      continue;
    }
    const glm::dvec3 up(0, 0.5 * room, 0),
        side = glm::normalize(glm::cross(center, glm::dvec3(0, 1, 0))) * (0.5 * room);
    TriangleMesh mesh = quad(center - 0.5 * up - 0.5 * side, up, side);
    if (glm::dot(glm::cross(up, side), center) > 0.0) mesh = quad(center - 0.5 * up - 0.5 * side, side, up);
    mesh.triangles.push_back({0, 0, 2});  // no area: never chosen
    bodies.push_back(Body{mesh, diffuse(0.5), radiance});
  }
  bodies.push_back(Body{Sphere{.center = {0, 5, 0}, .radius = 0.1}, diffuse(0.5)});                    // no emitter
  bodies.push_back(Body{Sphere{.center = {0, -5, 0}, .radius = 0.1}, diffuse(0.5), glm::dvec3(0.0)});  // a dark one
  return bodies;
}

// Of a primitive; instances lie here as their shapes do.
double area_of(const Shape& shape, std::size_t primitive) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return 4.0 * kPi * sphere->radius * sphere->radius;
  const auto& mesh = std::get<TriangleMesh>(shape);
  const glm::uvec3 t = mesh.triangles[primitive];
  return triangle_area({mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]});
}
double area_of(const Shape& shape) {
  double area = 0.0;
  for (std::size_t i = 0; i < primitive_count(shape); ++i) area += area_of(shape, i);
  return area;
}
double power_of(const Scene& scene, const Instance& instance) {
  const AreaEmitter* emitter = scene.emitter_of(instance);
  if (emitter == nullptr) return 0.0;
  return area_of(scene.shape_of(instance)) *
         glm::dot(emitter->radiance.value, glm::dvec3(0.212671, 0.715160, 0.072169));
}

TEST_F(DeviceEmitter, LightsAreChosenInProportionToTheirPower) {
  for (const int count : {1, 2, 7, 50}) {
    const LightScene setup(ring_of_lights(count));
    constexpr std::size_t kSamples = 1 << 16;
    std::map<std::pair<gpu::uint, gpu::uint>, double> counts;
    for (const auto& a : sample(setup.compiled, random_cases(setup.normalization.point({0, 0, 0}), kSamples, 5)))
      ++counts[{a.instance, a.primitive}];
    double total = 0.0;
    for (const Instance& instance : setup.scene.instances) total += power_of(setup.scene, instance);
    std::vector<double> observed, expected;
    for (gpu::uint i = 0; i < setup.scene.instances.size(); ++i) {
      const Instance& instance = setup.scene.instances[i];
      const Shape& shape = setup.scene.shape_of(instance);
      const double density = power_of(setup.scene, instance) / (total * area_of(shape));
      for (gpu::uint k = 0; k < primitive_count(shape); ++k) {
        observed.push_back(counts[{i, k}]);
        expected.push_back(kSamples * density * area_of(shape, k));
        if (expected.back() == 0.0) {
          EXPECT_EQ(observed.back(), 0.0) << i << ' ' << k;
        }
      }
    }
    EXPECT_GT(chi_square_test(observed, expected).p_value, kSmallestP) << count << " lights";
  }
}

TEST_F(DeviceEmitter, ThresholdsBelongToTheUpperEntry) {
  const LightScene setup(ring_of_lights(9));
  std::vector<double> weights;
  for (const Instance& instance : setup.scene.instances) weights.push_back(power_of(setup.scene, instance));
  const auto thresholds = integer_thresholds(weights);
  std::vector<gpu::LightCase> cases;
  std::vector<gpu::uint> expected;
  const auto add = [&](std::uint64_t word, std::size_t shape_index) {
    cases.push_back({setup.normalization.point({0, 0, 0}),
                     0,
                     {static_cast<gpu::uint>(word), 0x1234567u, 99u, 7u},
                     glm::vec3(0.0f),
                     0});
    expected.push_back(static_cast<gpu::uint>(shape_index));
  };
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] == 0.0) continue;
    add(thresholds[i], i);
    add(thresholds[i + 1] - 1, i);
  }
  const auto answers = sample(setup.compiled, cases);
  for (std::size_t i = 0; i < cases.size(); ++i)
    EXPECT_EQ(answers[i].instance, expected[i]) << std::hex << cases[i].words.x;
}

TEST_F(DeviceEmitter, SamplingAndChanceAgreeOnTheDensity) {
  // The ray toward a sampled point meets that light with the radiance promised, and would have been found with the same
  // density.
  for (const int count : {1, 2, 7, 50}) {
    const LightScene setup(ring_of_lights(count));
    const glm::vec3 p = setup.normalization.point({0.02, 0.05, -0.03});
    const auto samples = sample(setup.compiled, random_cases(p, 4096, 6));
    std::vector<gpu::RayCase> rays;
    rays.reserve(samples.size());
    for (const auto& s : samples) rays.push_back({p, 0.0f, s.wi, INFINITY});
    const auto met = emission(setup.compiled, rays);
    std::size_t missed = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const bool same = met[i].instance == samples[i].instance;
      if (!same || (met[i].primitive != samples[i].primitive)) {
        ++missed;  // rays to the very rim
        continue;
      }
      EXPECT_EQ(met[i].radiance, samples[i].pdf_w > 0.0f ? samples[i].radiance : glm::vec3(0.0f));
      const double cosine = std::abs(glm::dot(samples[i].wi, samples[i].ng));
      EXPECT_NEAR(met[i].pdf, samples[i].mis_pdf, (1e-4 + 1e-5 / std::max(1e-3, cosine)) * samples[i].mis_pdf) << i;
      EXPECT_NEAR(met[i].t, glm::length(glm::dvec3(samples[i].p) - glm::dvec3(p)), 2e-6 / std::max(1e-3, cosine));
      // With primitives of a shape chosen by area, both densities of a sample are one and the same.
      EXPECT_NEAR(samples[i].pdf_w, samples[i].mis_pdf, 1e-5 * samples[i].mis_pdf);
    }
    EXPECT_LT(missed, samples.size() / 500) << count << " lights";
  }
}

TEST_F(DeviceEmitter, DensityIntegratesToOne) {
  // Over uniform directions E[4π pdf] = 1 when all of every light is seen from its bright side.
  for (const int count : {1, 2, 7, 50}) {
    const LightScene setup(ring_of_lights(count));
    const glm::vec3 p = setup.normalization.point({0, 0, 0});
    Random random(7);
    constexpr int kRays = 1 << 18;
    std::vector<gpu::RayCase> rays;
    rays.reserve(kRays);
    for (int i = 0; i < kRays; ++i) rays.push_back({p, 0.0f, glm::vec3(random.direction()), INFINITY});
    RunningMoments integral;
    for (const auto& a : emission(setup.compiled, rays)) integral.add(4.0 * kPi * a.pdf);
    EXPECT_LT(std::abs(integral.mean() - 1.0), 4.5 * integral.standard_error() + 1e-5) << count << " lights";
    EXPECT_LT(integral.standard_error(), 0.03);
  }
}

// Lights of all sizes, shapes and directions around the origin; some cannot be seen from there.
std::vector<Body> crowd_of_lights(int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<Body> bodies;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 center = (0.5 + 4.0 * random.unit()) * random.direction();
    const glm::dvec3 radiance(0.1 + random.unit(), 0.1 + 3.0 * random.unit(), 0.1 + random.unit());
    const double size = 0.02 + 0.3 * random.unit();
    if (i % 3 == 0) {
      bodies.push_back(Body{Sphere{center, 0.4 * size}, diffuse(0.5), radiance});
    } else {
      bodies.push_back(
          Body{quad(center, size * random.direction(), size * random.direction()), diffuse(0.5), radiance});
    }
  }
  return bodies;
}

// A receiver in each of some places and directions.
struct Receiver {
  glm::dvec3 p, n;
};
std::vector<Receiver> some_receivers(std::size_t count) {
  Random random(4);
  std::vector<Receiver> receivers;
  receivers.reserve(count);
  for (std::size_t i = 0; i < count; ++i)
    receivers.push_back({(0.1 + 4.0 * random.unit()) * random.direction(), random.direction()});
  return receivers;
}

constexpr auto kTree = Integrator::LightSampler::tree;

TEST_F(DeviceEmitter, TheTreeChoosesLikeTheReference) {
  for (const int count : {1, 2, 33, 1000}) {
    const LightScene setup(crowd_of_lights(count, 8), kTree);
    const reference::Lights lights(setup.scene);
    std::vector<gpu::LightCase> cases;
    std::vector<Receiver> receivers;
    Random random(9);
    for (const Receiver& r : some_receivers(64)) {
      for (int i = 0; i < 256; ++i) {
        const gpu::uint a = random.word(), b = random.word(), c = random.word();
        cases.push_back({setup.normalization.point(r.p), 0, {a, b, c, random.word()}, glm::vec3(r.n), 0});
        receivers.push_back(r);
      }
    }
    const auto answers = sample(setup.compiled, cases);
    std::size_t other = 0, none = 0, off = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      const glm::uvec4 w = cases[i].words;
      const auto expected = lights.sample(setup.scene, receivers[i].p, receivers[i].n,
                                          {w.x, w.y, reference::unit_float(w.z), reference::unit_float(w.w)});
      none += !expected;
      if (!expected || answers[i].instance == gpu::kNone) {
        other += expected.has_value() != (answers[i].instance != gpu::kNone);
        if (answers[i].instance == gpu::kNone) {
          EXPECT_EQ(answers[i].pdf_w, 0.0f);
        }
        continue;
      }
      if (answers[i].instance != expected->instance || answers[i].primitive != expected->primitive) {
        ++other;
        continue;
      }
      const double scale = setup.normalization.scale;
      const double distance = glm::length(expected->surface.p - receivers[i].p) * scale;
      const double cosine = std::abs(glm::dot(expected->wi, expected->surface.ng));
      off += !(std::abs(answers[i].pdf_w - expected->pdf_w) <=
               (2e-4 + 3e-5 / std::max(1e-3, cosine * distance)) * expected->pdf_w);
    }
    EXPECT_LE(other, cases.size() / 5000) << count << " lights";
    EXPECT_LE(off, cases.size() / 500) << count << " lights";
    EXPECT_LT(none, cases.size() * 3 / 4) << "hardly anything was tested";
  }
}

TEST_F(DeviceEmitter, TheTreeChoosesWithTheProbabilitiesItSays) {
  for (const int count : {2, 33, 300}) {
    const LightScene setup(crowd_of_lights(count, 10), kTree);
    const reference::Lights lights(setup.scene);
    for (const Receiver& r : some_receivers(3)) {
      constexpr std::size_t kSamples = 1 << 16;
      std::vector<gpu::LightCase> cases = random_cases(setup.normalization.point(r.p), kSamples, 11);
      for (gpu::LightCase& c : cases) c.n = glm::vec3(r.n);
      std::map<std::pair<gpu::uint, gpu::uint>, double> counts;
      for (const auto& a : sample(setup.compiled, cases)) ++counts[{a.instance, a.primitive}];
      std::vector<double> observed, expected;
      double rest = kSamples;
      for (gpu::uint i = 0; i < setup.scene.instances.size(); ++i) {
        for (gpu::uint k = 0; k < primitive_count(setup.scene.shape_of(setup.scene.instances[i])); ++k) {
          observed.push_back(counts[{i, k}]);
          expected.push_back(kSamples * lights.prob(r.p, r.n, i, k, {}));
          rest -= expected.back();
        }
      }
      double chosen = 0.0;
      for (const double c : observed) chosen += c;
      observed.push_back(kSamples - chosen);  // no light can contribute
      expected.push_back(std::max(0.0, rest));
      EXPECT_GT(chi_square_test(observed, expected).p_value, kSmallestP) << count << " lights";
    }
  }
}

TEST_F(DeviceEmitter, SamplingByTreeAndChanceAgreeOnTheDensity) {
  const LightScene setup(ring_of_lights(50), kTree);
  const glm::vec3 p = setup.normalization.point({0.02, 0.05, -0.03});
  const auto samples = sample(setup.compiled, random_cases(p, 4096, 6));
  std::vector<gpu::RayCase> rays;
  rays.reserve(samples.size());
  for (const auto& s : samples) rays.push_back({p, 0.0f, s.wi, INFINITY});
  const auto met = emission(setup.compiled, rays);
  std::size_t missed = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (met[i].instance != samples[i].instance || met[i].primitive != samples[i].primitive) {
      ++missed;  // rays to the very rim
      continue;
    }
    const double cosine = std::abs(glm::dot(samples[i].wi, samples[i].ng));
    EXPECT_NEAR(met[i].pdf, samples[i].mis_pdf, (1e-4 + 1e-5 / std::max(1e-3, cosine)) * samples[i].mis_pdf) << i;
    EXPECT_NEAR(samples[i].pdf_w, samples[i].mis_pdf, 1e-5 * samples[i].mis_pdf);
  }
  EXPECT_LT(missed, samples.size() / 500);
}

TEST_F(DeviceEmitter, TheDensityOfTheTreeIntegratesToOne) {
  // As above; without a normal no light is below a horizon.
  const LightScene setup(ring_of_lights(50), kTree);
  const glm::vec3 p = setup.normalization.point({0, 0, 0});
  Random random(7);
  constexpr int kRays = 1 << 18;
  std::vector<gpu::RayCase> rays;
  rays.reserve(kRays);
  for (int i = 0; i < kRays; ++i) rays.push_back({p, 0.0f, glm::vec3(random.direction()), INFINITY});
  RunningMoments integral;
  for (const auto& a : emission(setup.compiled, rays)) integral.add(4.0 * kPi * a.pdf);
  EXPECT_LT(std::abs(integral.mean() - 1.0), 4.5 * integral.standard_error() + 1e-5);
  EXPECT_LT(integral.standard_error(), 0.03);
}

// A picture of one bright texel in a dark frame, on a square that shines down on the origin, beside an even lamp.
Scene pictured_lamp(bool mirrored) {
  Scene scene;
  TriangleMesh screen = quad({-1, 1.5, -1}, {2, 0, 0}, {0, 0, 2});
  screen.uv_sets.push_back({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  auto picture = std::make_shared<Bitmap>();
  picture->width = picture->height = 5;
  picture->channels = 1;
  picture->format = BitmapFormat::u8;
  picture->texels.assign(25, std::byte{1});
  picture->texels[8] = std::byte{255};
  picture->color_space = ColorSpace::linear;
  scene.bitmaps = {picture};
  scene.textures.push_back({.source = BitmapTexture{.bitmap = 0, .filter = TextureFilter::nearest}, .name = "screen"});
  Instance& lamp = scene.add(screen, diffuse(0.0), AreaEmitter{ColorParameter(glm::dvec3(8.0), 0)});
  if (mirrored) lamp.world_from_object[0][0] = -1.0;
  reference::test::add(scene, triangle({2, 0.5, -1}, {2, 0.5, 1}, {2, 1.5, 0}), diffuse(0.0), glm::dvec3(0.5));
  return scene;
}

// What is chosen, where the point is and how dense such points are, against the reference.
TEST_F(DeviceEmitter, PartsOfALampAreSampledAsTheReferenceDoes) {
  for (const bool mirrored : {false, true}) {
    for (const auto sampler : {Integrator::LightSampler::power, kTree}) {
      const LightScene setup(pictured_lamp(mirrored), sampler);
      ASSERT_TRUE(setup.compiled.lamp_parts);
      const reference::Lights lights(setup.scene);
      const glm::dvec3 p(0.1, 0.0, -0.2), n(0.0, 1.0, 0.0);
      std::vector<gpu::LightCase> cases = random_cases(setup.normalization.point(p), 4096, 12);
      for (gpu::LightCase& c : cases) c.n = glm::vec3(n);
      const auto answers = sample(setup.compiled, cases);
      std::size_t other = 0, lit = 0;
      for (std::size_t i = 0; i < answers.size(); ++i) {
        const glm::uvec4 w = cases[i].words;
        const auto unit = [](gpu::uint word) { return static_cast<double>(word >> 8) * 0x1p-24; };
        const auto expected = lights.sample(setup.scene, p, n, {w.x, w.y, unit(w.z), unit(w.w)});
        ASSERT_TRUE(expected);
        const glm::dvec3 at = setup.normalization.point(expected->surface.p);
        const bool same =
            answers[i].instance == expected->instance && glm::distance(glm::dvec3(answers[i].p), at) < 1e-5;
        other += same ? 0 : 1;
        if (!same) continue;
        EXPECT_NEAR(answers[i].pdf_w, expected->pdf_w, 1e-4 * expected->pdf_w) << i;
        EXPECT_NEAR(answers[i].mis_pdf, expected->pdf_w_mis, 1e-4 * expected->pdf_w_mis) << i;
        EXPECT_NEAR(expected->pdf_w_mis, lights.pdf_w_mis(setup.scene, p, n, expected->surface),
                    1e-9 * expected->pdf_w);
        lit += answers[i].instance == 0 && expected->radiance.x > 1.0 ? 1 : 0;
      }
      EXPECT_LE(other, cases.size() / 1000);
      EXPECT_GT(lit, cases.size() / 3) << "one texel in 25 gives nine tenths of the light";
    }
  }
}

TEST_F(DeviceEmitter, SamplingAPartAndChanceAgreeOnTheDensity) {
  for (const auto sampler : {Integrator::LightSampler::power, kTree}) {
    const LightScene setup(pictured_lamp(true), sampler);
    const glm::vec3 p = setup.normalization.point({0.3, 0.1, 0.2});
    const auto samples = sample(setup.compiled, random_cases(p, 4096, 13));
    std::vector<gpu::RayCase> rays;
    for (const auto& s : samples) rays.push_back({p, 0.0f, s.wi, INFINITY});
    const auto met = emission(setup.compiled, rays);
    std::size_t missed = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const bool same = met[i].instance == samples[i].instance && met[i].primitive == samples[i].primitive;
      missed += same && std::abs(met[i].pdf - samples[i].mis_pdf) <= 1e-3 * samples[i].mis_pdf ? 0 : 1;
    }
    EXPECT_LT(missed, samples.size() / 500) << "more than the rims of triangles and parts";
  }
}

}  // namespace
}  // namespace etendue::test
