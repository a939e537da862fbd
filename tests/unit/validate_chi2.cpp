/// The chi-square test of materials: quadrature, false alarms, and materials with a planted error.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "reference/material_probe.h"
#include "reference/reference_renderer.h"
#include "scene/test_patch.h"
#include "validate/chi2.h"
#include "validate/selftest.h"
#include "validate/sphere_quadrature.h"

namespace etendue {
namespace {

using glm::dvec3;
constexpr double kPi = std::numbers::pi;

std::vector<double> clamped_cosine(std::span<const dvec3> directions, const dvec3& axis) {
  std::vector<double> values;
  for (const dvec3& d : directions) values.push_back(std::max(0.0, glm::dot(d, axis)) / kPi);
  return values;
}

TEST(SphereQuadrature, CellsAddUpAcrossKinks) {
  for (const dvec3& axis : {dvec3(0, 0, 1), glm::normalize(dvec3(0.3, -0.5, 0.2)), dvec3(1, 0, 0)}) {
    for (const int rings : {1, 3, 10}) {
      double sum = 0.0;
      for (const double cell : integrate_cells([&](auto d) { return clamped_cosine(d, axis); }, rings, 2 * rings))
        sum += cell;
      EXPECT_NEAR(sum, 1.0, 2e-5) << rings;
    }
  }
}

TEST(SphereQuadrature, EachCellIsItsOwn) {
  const std::vector<double> cells = integrate_cells([](auto d) { return clamped_cosine(d, {0, 0, 1}); }, 4, 8);
  for (int sector = 0; sector < 8; ++sector) {
    EXPECT_EQ(cells[sector], 0.0);
    EXPECT_NEAR(cells[2 * 8 + sector], 0.25 / 8, 1e-9);  // cos θ from 0 to 1/2
    EXPECT_NEAR(cells[3 * 8 + sector], 0.75 / 8, 1e-9);
  }
}

/// The reference's diffuse material with its answers changed on the way out.
class WrongProbe final : public BsdfProbe {
 public:
  std::function<void(BsdfDraw&)> change_draw = [](BsdfDraw&) {};
  std::function<void(BsdfValue&)> change_value = [](BsdfValue&) {};

  explicit WrongProbe(const Scene& patch) : right_(make_reference_bsdf_probe(patch)) {}
  std::string device_name() const override { return "wrong"; }
  std::string driver_name() const override { return "wrong"; }
  std::vector<BsdfDraw> sample(const dvec3& wo, std::uint32_t seed, std::uint32_t first, std::uint32_t count) override {
    std::vector<BsdfDraw> draws = right_->sample(wo, seed, first, count);
    for (BsdfDraw& draw : draws) change_draw(draw);
    return draws;
  }
  std::vector<BsdfValue> evaluate(const dvec3& wo, std::uint32_t seed, std::span<const BsdfQuery> queries,
                                  Part part) override {
    std::vector<BsdfValue> values = right_->evaluate(wo, seed, queries, part);
    for (BsdfValue& value : values) change_value(value);
    return values;
  }

 private:
  std::unique_ptr<BsdfProbe> right_;
};

const dvec3 kWo = glm::normalize(dvec3(0.3, -0.2, 0.6));

BsdfChi2 test(BsdfProbe& probe, const Bsdf& bsdf, std::uint32_t seed = 1, std::uint64_t samples = 200000,
              double level = 1e-3) {
  return test_bsdf(probe, test_patch(bsdf), kWo, Chi2Test{}, samples, seed, level);
}

TEST(Chi2, TheReferencePasses) {
  for (const Bsdf& bsdf : {Bsdf(DiffuseBsdf{{0.9, 0.5, 0.1}}), Bsdf(MirrorBsdf{}), Bsdf(DielectricBsdf{}),
                           Bsdf(DielectricBsdf{1.0, 2.4})}) {
    const auto probe = make_reference_bsdf_probe(test_patch(bsdf));
    const BsdfChi2 result = test(*probe, bsdf);
    EXPECT_TRUE(result.passed) << result.fault << ' ' << result.test.p_value;
  }
}

// From behind a one-sided material is black: no sample has a direction, and no direction a density.
TEST(Chi2, AnglesBeyondTheSurfaceTestTheBackOfAMaterial) {
  Chi2Test test;
  test.bsdfs = {{test_patch(DiffuseBsdf{}), "diffuse", {}},
                {test_patch(MirrorBsdf{}), "mirror", {}},
                {test_patch(DielectricBsdf{}), "dielectric", {}}};
  test.angles = {30.0, 150.0};
  test.test_count = 2;
  const Chi2Report report = run_chi2(test, "x.xml", make_reference_bsdf_probe);
  ASSERT_EQ(report.tests.size(), 3u * 2 * 2);
  EXPECT_TRUE(report.passed()) << chi2_table(report);
  for (std::size_t i = 0; i < report.tests.size(); ++i) {
    const BsdfChi2& t = report.tests[i];
    const bool behind = i / 2 % 2 == 1, one_sided = i < 8;
    EXPECT_NEAR(t.wo.z, behind ? -std::sqrt(0.75) : std::sqrt(0.75), 1e-12) << t.name;
    EXPECT_EQ(t.without_direction, behind && one_sided ? t.samples : 0) << t.name;
  }
  // A diffuse material that shines from behind is found out.
  test.bsdfs.resize(1);
  const auto two_sided = [](const Scene& patch) {
    auto probe = std::make_unique<WrongProbe>(patch);
    probe->change_draw = [](BsdfDraw& draw) {
      if (draw.pdf == 0.0) draw = {{0.0, 0.0, -1.0}, 1.0 / kPi, {0.5, 0.5, 0.5}, ProbeLobe::diffuse};
    };
    return probe;
  };
  EXPECT_FALSE(run_chi2(test, "x.xml", two_sided).passed());
  test.angles = {30.0};
  EXPECT_TRUE(run_chi2(test, "x.xml", two_sided).passed());
}

TEST(Chi2, FalseAlarmRateIsWhatItSays) {
  const auto probe = make_reference_bsdf_probe(test_patch(DiffuseBsdf{}));
  std::uint64_t failed = 0;
  for (std::uint32_t seed = 0; seed < 400; ++seed) failed += !test(*probe, DiffuseBsdf{}, seed, 4000, 0.05).passed;
  EXPECT_GT(binomial_two_sided(failed, 400, 0.05), 1e-3) << failed;
}

TEST(Chi2, AHistogramOfOneCellIsNoTest) {
  const auto probe = make_reference_bsdf_probe(test_patch(DiffuseBsdf{}));
  const BsdfChi2 few = test(*probe, DiffuseBsdf{}, 1, 4);
  EXPECT_EQ(few.test.p_value, 1.0);
  EXPECT_FALSE(few.tested);
  EXPECT_FALSE(few.passed);
  EXPECT_TRUE(test(*probe, DiffuseBsdf{}, 1, 4000).tested);
  // A mirror has one direction, and all samples are there or not.
  const auto mirror = make_reference_bsdf_probe(test_patch(MirrorBsdf{}));
  EXPECT_TRUE(test(*mirror, MirrorBsdf{}, 1, 4).passed);
  Chi2Test file;
  file.test_count = 1;
  file.bsdfs.push_back({.patch = test_patch(DiffuseBsdf{}), .name = "diffuse", .position = {}});
  Chi2Options options;
  options.sample_count = 4;
  const Chi2Report report = run_chi2(file, "few", make_reference_bsdf_probe, options);
  EXPECT_FALSE(report.passed());
  EXPECT_NE(chi2_table(report).find("NOT TESTED: 4 samples"), std::string::npos);
  options.allow_untested = true;
  EXPECT_TRUE(run_chi2(file, "few", make_reference_bsdf_probe, options).passed());
}

TEST(Selftest, TestsThatCouldNotBeMadeAreNoPass) {
  SelftestOptions options;
  options.samples = 4;
  const RendererFactory reference = [](const SharedScene& scene, const RenderSettings& settings) {
    return make_reference_renderer(scene.scene(), settings);
  };
  SelftestReport report = run_selftest(reference, make_reference_bsdf_probe, options);
  EXPECT_GT(report.untested, 0u);
  EXPECT_FALSE(report.passed());
  EXPECT_NE(selftest_text(report).find("could not be made"), std::string::npos);
  report.options.allow_untested = true;
  EXPECT_EQ(report.passed(), report.failed_suites == 0);
}

TEST(Chi2, DensitiesOffByTwoPercentFail) {
  WrongProbe both{test_patch(DiffuseBsdf{})};  // consistent with itself, but no density
  both.change_draw = [](BsdfDraw& d) { d.pdf *= 1.02, d.weight /= 1.02; };
  both.change_value = [](BsdfValue& v) { v.pdf *= 1.02; };
  EXPECT_NE(test(both, DiffuseBsdf{}).fault.find("integrates to 1.02"), std::string::npos);
  WrongProbe small{test_patch(DiffuseBsdf{})};
  small.change_draw = [](BsdfDraw& d) { d.pdf *= 0.98, d.weight /= 0.98; };
  small.change_value = [](BsdfValue& v) { v.pdf *= 0.98; };
  EXPECT_FALSE(test(small, DiffuseBsdf{}).passed);  // 2 % of the samples should have had no direction
  WrongProbe sampled{test_patch(DiffuseBsdf{})};
  sampled.change_draw = [](BsdfDraw& d) { d.pdf *= 1.02; };
  EXPECT_NE(test(sampled, DiffuseBsdf{}).fault.find("pdf of a sample"), std::string::npos);
}

TEST(Chi2, WrongWeightsFail) {
  WrongProbe probe{test_patch(DiffuseBsdf{})};
  probe.change_draw = [](BsdfDraw& d) { d.weight *= 1.01; };
  EXPECT_NE(test(probe, DiffuseBsdf{}).fault.find("weight"), std::string::npos);
}

TEST(Chi2, DirectionsBesideTheDensityFail) {
  WrongProbe turned{test_patch(DiffuseBsdf{})};  // 3 % steeper than the density says
  turned.change_draw = [](BsdfDraw& d) { d.wi = glm::normalize(dvec3(d.wi.x, d.wi.y, 1.03 * d.wi.z)); };
  turned.change_value = [](BsdfValue&) {};
  EXPECT_FALSE(test(turned, DiffuseBsdf{}).passed);
  std::mt19937_64 engine(5);
  WrongProbe lost{test_patch(DiffuseBsdf{})};  // one sample in a thousand has no direction
  lost.change_draw = [&](BsdfDraw& d) {
    if (engine() % 1000 == 0) d = {};
  };
  EXPECT_FALSE(test(lost, DiffuseBsdf{}).passed);
  WrongProbe below{test_patch(DiffuseBsdf{})};  // one in a thousand leaves below the surface
  below.change_draw = [&](BsdfDraw& d) {
    if (engine() % 1000 == 0) d.wi.z = -d.wi.z;
  };
  EXPECT_FALSE(test(below, DiffuseBsdf{}).passed);
  WrongProbe nan{test_patch(DiffuseBsdf{})};
  nan.change_value = [](BsdfValue& v) { v.pdf = std::nan(""); };
  EXPECT_FALSE(test(nan, DiffuseBsdf{}).passed);
}

TEST(Chi2, WrongDeltaLobesFail) {
  const Bsdf glass = DielectricBsdf{};
  WrongProbe bent{test_patch(glass)};
  bent.change_draw = [](BsdfDraw& d) { d.wi = glm::normalize(d.wi + dvec3(0.001, 0, 0)); };
  EXPECT_NE(test(bent, glass).fault.find("delta sample"), std::string::npos);
  WrongProbe unscaled{test_patch(glass)};
  unscaled.change_draw = [](BsdfDraw& d) { d.weight = dvec3(1.0); };
  EXPECT_FALSE(test(unscaled, glass).passed);
  std::mt19937_64 engine(6);
  WrongProbe biased{test_patch(glass)};  // reflects a little too often, with the probabilities still right
  const auto lobes = make_reference_bsdf_probe(test_patch(glass))->sample(kWo, 1, 0, 1000);
  const auto reflection = std::ranges::find(lobes, ProbeLobe::delta_reflection, &BsdfDraw::lobe);
  biased.change_draw = [&](BsdfDraw& d) {
    if (engine() % 100 == 0) d = *reflection;
  };
  EXPECT_FALSE(test(biased, glass).passed);
  WrongProbe missing{test_patch(glass)};
  missing.change_draw = [](BsdfDraw& d) { d.lobe = ProbeLobe::diffuse; };
  EXPECT_FALSE(test(missing, glass).passed);
}

/// Stacks of adapters; the last material of each table is the one that is tested.
struct Stack {
  Scene scene;
  std::uint32_t add(Material material) {
    scene.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(scene.materials.size() - 1);
  }
  std::uint32_t add(Bsdf bsdf) { return add(Material{.bsdf = std::move(bsdf)}); }
  std::uint32_t adapt(Adapter adapter) { return add(Material{.bsdf = DiffuseBsdf{}, .adapter = std::move(adapter)}); }
  Scene patch() {
    add_test_patch(scene);
    return std::move(scene);
  }
};

const RoughConductorBsdf kMetal{.roughness = {Roughness::Distribution::ggx, 0.3, 0.2}};

Scene blend(double weight, double inner_weight = 0.6) {
  Stack stack;
  const std::uint32_t glass = stack.add(DielectricBsdf{}), metal = stack.add(kMetal), matt = stack.add(DiffuseBsdf{});
  const std::uint32_t inner = stack.adapt(BlendAdapter{inner_weight, glass, metal});
  stack.adapt(BlendAdapter{weight, inner, matt});
  return stack.patch();
}

Scene two_sided(bool swapped) {
  Stack stack;
  const std::uint32_t metal = stack.add(kMetal), matt = stack.add(DiffuseBsdf{});
  stack.adapt(swapped ? TwoSidedAdapter{matt, metal} : TwoSidedAdapter{metal, matt});
  return stack.patch();
}

Scene mask(double opacity) {
  Stack stack;
  stack.adapt(MaskAdapter{opacity, stack.add(kMetal)});
  return stack.patch();
}

/// A normal map tilted toward ±X over a half mirror.
Scene tilted(double x) {
  Stack stack;
  Texture color{.source = CheckerboardTexture{glm::dvec3(0.5 + x, 0.4, 0.9), glm::dvec3(0.5 + x, 0.4, 0.9)}};
  stack.scene.textures.push_back(color);
  const std::uint32_t mirror = stack.add(MirrorBsdf{}), matt = stack.add(DiffuseBsdf{});
  const std::uint32_t half = stack.adapt(BlendAdapter{0.7, mirror, matt});
  stack.adapt(NormalMapAdapter{.normals = ColorParameter(glm::dvec3(1.0), 0), .inner = half});
  return stack.patch();
}

BsdfChi2 test_patch_with(BsdfProbe& probe, const Scene& patch, std::uint32_t seed = 1) {
  return test_bsdf(probe, patch, kWo, Chi2Test{}, 100000, seed, 1e-3);
}

TEST(Chi2, AdaptersPass) {
  for (const Scene& patch : {blend(0.3), blend(1.0), two_sided(false), mask(0.4), mask(0.0), tilted(0.3)}) {
    const auto probe = make_reference_bsdf_probe(patch);
    const BsdfChi2 result = test_patch_with(*probe, patch);
    EXPECT_TRUE(result.passed) << result.fault << ' ' << result.test.p_value;
  }
  const auto probe = make_reference_bsdf_probe(tilted(0.4));
  EXPECT_GT(test_patch_with(*probe, tilted(0.4)).without_light, 0u);  // below one of the two horizons
}

// Tested as another stack than it is.
TEST(Chi2, WrongChoicesOfAdaptersFail) {
  const auto passes = [](const Scene& is, const Scene& should_be) {
    const auto probe = make_reference_bsdf_probe(is);
    return test_patch_with(*probe, should_be).passed;
  };
  EXPECT_FALSE(passes(blend(0.7), blend(0.3)));
  EXPECT_FALSE(passes(blend(0.32), blend(0.3)));
  EXPECT_FALSE(passes(blend(0.3, 0.62), blend(0.3, 0.6)));
  EXPECT_FALSE(passes(two_sided(true), two_sided(false)));
  EXPECT_FALSE(passes(mask(0.42), mask(0.4)));
  EXPECT_FALSE(passes(tilted(-0.3), tilted(0.3)));
}

/// Mixtures whose density is 2 % too large everywhere, in samples as well.
class WrongMixture final : public BsdfProbe {
 public:
  explicit WrongMixture(const Scene& patch) : right_(make_reference_bsdf_probe(patch)) {}
  std::string device_name() const override { return "wrong"; }
  std::string driver_name() const override { return "wrong"; }
  std::vector<BsdfDraw> sample(const dvec3& wo, std::uint32_t seed, std::uint32_t first, std::uint32_t count) override {
    std::vector<BsdfDraw> draws = right_->sample(wo, seed, first, count);
    for (BsdfDraw& draw : draws)
      if (!is_delta(draw.lobe)) draw.pdf *= 1.02, draw.weight /= 1.02;
    return draws;
  }
  std::vector<BsdfValue> evaluate(const dvec3& wo, std::uint32_t seed, std::span<const BsdfQuery> queries,
                                  Part part) override {
    std::vector<BsdfValue> values = right_->evaluate(wo, seed, queries, part);
    for (BsdfValue& value : values) value.pdf *= part == Part::mixture ? 1.02 : 1.0;
    return values;
  }

 private:
  std::unique_ptr<BsdfProbe> right_;
};

TEST(Chi2, WrongDensitiesOfMixturesFail) {
  WrongMixture probe(blend(0.3));
  EXPECT_NE(test_patch_with(probe, blend(0.3)).fault.find("density of a mixture"), std::string::npos);
}

TEST(Chi2, TooManyChoicesAreRefused) {
  Stack stack;
  std::vector<std::uint32_t> layer;
  for (int i = 0; i < 1 << 7; ++i) layer.push_back(stack.add(DiffuseBsdf{}));
  while (layer.size() > 1) {
    std::vector<std::uint32_t> next;
    for (std::size_t i = 0; i + 1 < layer.size(); i += 2)
      next.push_back(stack.adapt(BlendAdapter{0.5, layer[i], layer[i + 1]}));
    layer = next;
  }
  const Scene patch = stack.patch();
  const auto probe = make_reference_bsdf_probe(patch);
  try {
    test_patch_with(*probe, patch);
    FAIL() << "2 · 64 · 64 combinations";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("more than 4096 combinations"), std::string::npos);
  }
}

TEST(BsdfTTest, FindsAWrongAlbedo) {
  TTest file;
  file.angles = {0, 45};
  file.bsdfs.push_back({.patch = test_patch(DielectricBsdf{1.5, 1.0}), .name = "dielectric 1", .position = {}});
  const double f = 0.04, g = 0.0502399;  // at 45°
  file.references = {f + (1 - f) / 2.25, g + (1 - g) / 2.25};
  EXPECT_TRUE(run_bsdf_ttest(file, "glass", make_reference_bsdf_probe).passed());
  file.references[1] = 1.0;  // energy instead of radiance
  const TTestReport report = run_bsdf_ttest(file, "glass", make_reference_bsdf_probe);
  EXPECT_TRUE(report.scenes[0].passed);
  EXPECT_FALSE(report.scenes[1].passed);
  file.references.pop_back();
  EXPECT_THROW(run_bsdf_ttest(file, "glass", make_reference_bsdf_probe), std::runtime_error);
}

}  // namespace
}  // namespace etendue
