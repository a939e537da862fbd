// Device against reference with fake renderers: each verdict, and each defect found and named.

#include "validate/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "validate_fake_renderer.h"

namespace etendue {
namespace {

using test::Defects;
using test::fake;
using test::small_scene;
using ::testing::HasSubstr;

ValidateOptions quick() {
  ValidateOptions options;
  options.sample_budget = 1 << 16;
  return options;
}

Validation validate_with(const Defects& defects, const ValidateOptions& options = quick()) {
  return validate_scene(small_scene(48, 32), fake(defects), fake(), options);
}

TEST(Validate, TheSameRendererIsIdentical) {
  const Validation v = validate_with({});
  EXPECT_EQ(v.verdict, Verdict::identical) << validation_text(v);
  EXPECT_TRUE(v.passed());
  EXPECT_EQ(v.samples.equal_bits, v.samples.samples);
  EXPECT_EQ(v.samples_per_pixel, 16u);
  EXPECT_NE(v.device_image.pixels, v.reference_image.pixels) << "L3 needs independent seeds";
}

TEST(Validate, NoiseThatHidesEverythingIsNoVerdict) {
  ValidateOptions options = quick();
  options.samples_per_pixel = 2;
  Validation v = validate_scene(small_scene(1, 1), fake(), fake(), options);
  EXPECT_EQ(v.verdict, Verdict::untested) << validation_text(v);
  EXPECT_FALSE(v.passed());
  EXPECT_THAT(validation_text(v), HasSubstr("verdict: not tested: the noise hides"));
  v.allow_untested = true;
  EXPECT_TRUE(v.passed());
  EXPECT_TRUE(validation_junit(v).skipped);
  options.samples_per_pixel = 64;
  options.sample_budget = 1;
  EXPECT_EQ(validate_scene(small_scene(1, 1), fake(), fake(), options).verdict, Verdict::untested);
}

TEST(Validate, RoundingIsRounding) {
  Defects rounding;
  rounding.rounding = 1e-6f;
  rounding.flip_every = 20000;
  const Validation v = validate_with(rounding);
  EXPECT_EQ(v.verdict, Verdict::rounding_only) << validation_text(v);
  EXPECT_GT(v.samples.flips, 0u);
  EXPECT_LT(v.samples.max_error, 2e-6);
  EXPECT_GT(v.samples.median_error, 1e-8);
  ValidateOptions strict = quick();
  strict.worst_accepted = Verdict::identical;
  EXPECT_FALSE(validate_with(rounding, strict).passed());
}

TEST(Validate, OtherRandomNumbersAreStatisticallyEqual) {
  Defects other;
  other.reuse_seed = true;
  const Validation v = validate_with(other);
  EXPECT_EQ(v.verdict, Verdict::statistically_equal) << validation_text(v);
  EXPECT_GT(v.samples.flips_per_million(), 9e5);
}

TEST(Validate, ABiasOfTwoPercentAtOneBounceIsFoundAndNamed) {
  Defects biased;
  biased.bias = 1.02f;
  biased.biased_bounce = 1;
  const Validation v = validate_with(biased);
  EXPECT_EQ(v.verdict, Verdict::different);
  EXPECT_FALSE(v.passed());
  EXPECT_LT(v.samples.paired.p_value, 1e-100);
  ASSERT_FALSE(v.samples.located.empty());
  EXPECT_EQ(v.samples.located.front().bounce, 1u);
  EXPECT_EQ(v.samples.located.front().what, "radiance");
  EXPECT_EQ(v.samples.first_differences.begin()->first, "bounce 1: radiance");
  EXPECT_THAT(validation_text(v), HasSubstr("bounce 1: radiance is ("));
}

TEST(Validate, ABiasHiddenFromTheDecisionsIsFoundWithOtherRandomNumbersToo) {
  // No pairing helps here: L3 alone, 4 % of the image mean.
  Defects biased;
  biased.bias = 1.07f;
  biased.biased_bounce = 0;
  biased.reuse_seed = true;
  const Validation v = validate_with(biased);
  EXPECT_EQ(v.verdict, Verdict::different) << validation_text(v);
  EXPECT_FALSE(v.tests.families.back().passed());
}

TEST(Validate, ASmallSystematicErrorIsNoRounding) {
  Defects biased;
  biased.bias = 1.001f;
  const Validation v = validate_with(biased);
  EXPECT_EQ(v.verdict, Verdict::different) << validation_text(v);
}

TEST(Validate, FlipsAreCountedAndNamed) {
  Defects flips;
  flips.flip_every = 50;
  const Validation v = validate_with(flips);
  EXPECT_EQ(v.verdict, Verdict::statistically_equal) << validation_text(v);
  EXPECT_NEAR(v.samples.flips_per_million(), 20000, 3000);
  EXPECT_GT(v.samples.first_differences.at("bounce 2: lobe"), 0u);
  EXPECT_EQ(v.samples.median_error, 0.0);
}

TEST(Validate, NanIsDifferentAndLocated) {
  Defects nan;
  nan.nan_every = 10000;
  const Validation v = validate_with(nan);
  EXPECT_EQ(v.verdict, Verdict::different);
  EXPECT_GT(v.device_rejected, 0u);
  EXPECT_GT(v.samples.non_finite, 0u);
  EXPECT_EQ(v.samples.located.front().bounce, 1u);
  EXPECT_THAT(validation_text(v), HasSubstr("rejected samples"));
}

// A scene in which rounding alone parts many paths: what a shaken reference does is allowed, and not much more.
TEST(Validate, LimitsFollowTheShakenReference) {
  Defects device, shaken;
  device.flip_every = shaken.flip_every = 100;
  ValidateOptions options = quick();
  EXPECT_EQ(validate_with(device, options).verdict, Verdict::statistically_equal);
  options.make_shaken = fake(shaken);
  const Validation v = validate_with(device, options);
  EXPECT_EQ(v.verdict, Verdict::rounding_only) << validation_text(v);
  EXPECT_NEAR(v.rounding->flips_per_million(), 1e4, 1e3);
  EXPECT_THAT(validation_text(v), HasSubstr("perturbed by rounding alone"));
  device.flip_every = 50;
  EXPECT_EQ(validate_with(device, options).verdict, Verdict::statistically_equal);
  device.flip_every = 20000;
  EXPECT_FALSE(validate_with(device, options).rounding.has_value()) << "not asked where the limits hold";
}

TEST(Validate, LargeFilmsAreSampledSparsely) {
  Defects biased;
  biased.bias = 1.02f;
  test::FakeRenderer device(small_scene(1000, 700), {}, biased), reference(small_scene(1000, 700), {}, {});
  const SampleComparison s = compare_samples(device, reference, 1000, 700, 4000);
  EXPECT_EQ(s.samples, 4000u);
  EXPECT_FALSE(s.same_mean());
}

TEST(Validate, FalseAlarmsOfAllTestsTogether) {
  // Independent seeds, the same expectation: "different" at most as often as the stated 1 % (and 0.1 % for the paired
  // test).
  std::uint64_t alarms = 0;
  constexpr std::uint64_t kExperiments = 200;
  ValidateOptions options;
  options.sample_budget = 512;
  options.significance = 0.05;
  Defects other;
  other.reuse_seed = true;
  for (std::uint32_t i = 0; i < kExperiments; ++i) {
    options.seed = 100000 * i;
    alarms += validate_scene(small_scene(16, 16), fake(other), fake(), options).verdict == Verdict::different;
  }
  EXPECT_GT(binomial_upper_tail(alarms, kExperiments, 0.052), 1e-3) << alarms;
}

TEST(Validate, JsonSaysTheSame) {
  Defects biased;
  biased.bias = 1.02f;
  const Validation v = validate_with(biased);
  const nlohmann::json json = nlohmann::json::parse(validation_json(v).dump());
  EXPECT_EQ(json["verdict"], "different");
  EXPECT_FALSE(json["passed"].get<bool>());
  EXPECT_EQ(json["L2"]["samples"].get<std::uint64_t>(), v.samples.samples);
  EXPECT_EQ(json["L2"]["located"][0]["bounce"], 1);
}

TEST(Validate, AStoppedRenderHasNoVerdict) {
  ValidateOptions options = quick();
  options.progress = [](std::uint64_t, std::uint64_t) { return false; };
  EXPECT_THROW(validate_with({}, options), Error);
}

DevicesValidation validate_several(const std::vector<Defects>& devices, const ValidateOptions& options = quick()) {
  std::vector<LabelledFactory> factories;
  for (const Defects& defects : devices) factories.push_back({std::to_string(factories.size()), fake(defects)});
  return validate_devices(small_scene(48, 32), factories, fake(), options);
}

TEST(ValidateDevices, EveryPairIsThereWithSeedsOfItsOwn) {
  const DevicesValidation all = validate_several({{}, {}, {}});
  EXPECT_TRUE(all.passed()) << devices_text(all);
  EXPECT_EQ(all.verdict(), Verdict::identical);
  std::vector<std::string> names;
  for (const Validation& v : all.pairs) {
    names.push_back(v.device_label + "-" + v.reference_label);
    EXPECT_NE(v.device_image.pixels, v.reference_image.pixels) << names.back() << ": L3 needs independent seeds";
    EXPECT_EQ(v.samples.equal_bits, v.samples.samples);
  }
  EXPECT_THAT(names, ::testing::ElementsAre("0-reference", "1-reference", "2-reference", "1-0", "2-0", "2-1"));
  EXPECT_EQ(all.pairs[0].device_image.pixels, validate_with({}).device_image.pixels);
  EXPECT_EQ(all.pairs[0].reference_image.pixels, validate_with({}).reference_image.pixels);
}

TEST(ValidateDevices, TheOneThatIsWrongIsNamedInEveryPairOfIts) {
  Defects biased;
  biased.bias = 1.02f;
  const DevicesValidation all = validate_several({{}, biased});
  EXPECT_EQ(all.verdict(), Verdict::different);
  EXPECT_FALSE(all.passed());
  std::vector<Verdict> verdicts;
  for (const Validation& v : all.pairs) verdicts.push_back(v.verdict);
  EXPECT_THAT(verdicts, ::testing::ElementsAre(Verdict::identical, Verdict::different, Verdict::different));
  const std::string text = devices_text(all);
  EXPECT_THAT(text, HasSubstr("on device 1 and (")) << "what did not pass is told at length";
  EXPECT_THAT(text, HasSubstr("different  FAILED"));
  const nlohmann::json json = nlohmann::json::parse(devices_json(all).dump());
  EXPECT_EQ(json["pairs"].size(), 3u);
  EXPECT_EQ(json["pairs"][2]["labels"], nlohmann::json({"1", "0"}));
  EXPECT_FALSE(json["passed"]);
}

TEST(ValidateDevices, TwoDevicesMayBeApartByWhatBothMayBeFromTheReference) {
  Defects flips;
  flips.flip_every = 600;  // 1700 a million: each is within 2000 of the reference
  ValidateOptions options = quick();
  const DevicesValidation all = validate_several({flips, {}}, options);
  EXPECT_EQ(all.pairs[0].samples.limits.flips_per_million, options.limits.flips_per_million);
  EXPECT_EQ(all.pairs[2].samples.limits.flips_per_million, 2 * options.limits.flips_per_million);
  EXPECT_EQ(all.pairs[2].samples.limits.median_error, 2 * options.limits.median_error);
  EXPECT_EQ(all.verdict(), Verdict::rounding_only) << devices_text(all);
}

TEST(ValidateDevices, AllPairsTogetherRaiseNoMoreFalseAlarmsThanOne) {
  const DevicesValidation all = validate_several({{}, {}, {}});
  double quiet = 1.0;
  for (const Validation& v : all.pairs) quiet *= 1.0 - v.tests.significance;
  EXPECT_NEAR(1.0 - quiet, quick().significance, 1e-6);
  quiet = 1.0;
  for (const Validation& v : all.pairs) quiet *= 1.0 - v.samples.limits.paired_level;
  EXPECT_NEAR(1.0 - quiet, quick().limits.paired_level, 1e-6);
}

}  // namespace
}  // namespace etendue
