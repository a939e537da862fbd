// The t-test of scene files with a renderer of known expectation: verdicts, counts, reports and that errors are found.

#include "validate/ttest.h"

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

TTest make_test(std::vector<double> references, std::uint32_t width, std::uint32_t height, std::uint64_t samples) {
  TTest t;
  t.references = std::move(references);
  t.scenes.assign(t.references.size(), small_scene(width, height));
  t.sample_count = samples;
  return t;
}

TEST(RunTTest, RightMeansPassAndWrongOnesFail) {
  const TTestReport right = run_ttest(make_test({1.5, 1.5}, 1, 1, 100000), "t.xml", fake());
  EXPECT_TRUE(right.passed()) << ttest_table(right);
  EXPECT_NEAR(right.test_level, 1.0 - std::sqrt(0.99), 1e-12);
  EXPECT_EQ(right.scenes[0].test.n, 100000u);
  EXPECT_NEAR(right.scenes[0].test.mean, 1.5, 0.02);
  EXPECT_NE(right.scenes[0].test.mean, right.scenes[1].test.mean) << "scenes share their random numbers";

  const TTestReport wrong = run_ttest(make_test({1.5, 1.53}, 1, 1, 100000), "t.xml", fake());
  EXPECT_TRUE(wrong.scenes[0].passed);
  EXPECT_FALSE(wrong.scenes[1].passed);
  EXPECT_FALSE(wrong.passed());
}

TEST(RunTTest, FindsABiasOfTwoPercentAtOneVertex) {
  Defects defects;
  defects.bias = 1.02f;
  defects.biased_bounce = 0;
  EXPECT_FALSE(run_ttest(make_test({1.5}, 1, 1, 100000), "t.xml", fake(defects)).passed());
}

TEST(RunTTest, SpreadsSamplesOverTheFilmAndSaysHowMany) {
  const TTestReport report = run_ttest(make_test({1.5}, 7, 3, 100), "t.xml", fake());
  EXPECT_EQ(report.scenes[0].samples_per_pixel, 5u);  // ceil(100 / 21)
  EXPECT_EQ(report.scenes[0].test.n, 105u);
  EXPECT_EQ(report.scenes[0].tail.n, 105u);
  // A single sample has no variance; two are the least.
  EXPECT_EQ(run_ttest(make_test({1.5}, 1, 1, 1), "t.xml", fake()).scenes[0].test.n, 2u);
}

TEST(RunTTest, FalseAlarmRateOfTheFileIsWhatItSays) {
  std::uint64_t failed = 0;
  constexpr std::uint64_t kExperiments = 1000;
  TTest t = make_test({1.5, 1.5, 1.5}, 1, 1, 200);
  TTestOptions options;
  options.significance_level = 0.05;
  options.tail_samples = 0;
  for (std::uint32_t i = 0; i < kExperiments; ++i) {
    options.seed = 1000 * i;
    failed += !run_ttest(t, "t.xml", fake(), options).passed();
  }
  EXPECT_GT(binomial_two_sided(failed, kExperiments, 0.05), 1e-4) << failed;
}

TEST(RunTTest, TooFewSamplesAreNoPass) {
  // Two samples do not tell 1.5 from 2: no test, whatever p says.
  const TTest test = make_test({1.5, 2.0}, 1, 1, 2);
  const TTestReport report = run_ttest(test, "t.xml", fake());
  EXPECT_FALSE(report.passed());
  for (const SceneTTest& scene : report.scenes) {
    ASSERT_GE(scene.test.p_value, report.test_level);
    EXPECT_FALSE(scene.tested);
  }
  EXPECT_THAT(ttest_table(report), HasSubstr("NOT TESTED"));
  EXPECT_THAT(ttest_table(report), HasSubstr("0 of 2 passed, 2 not tested"));
  EXPECT_EQ(nlohmann::json::parse(ttest_json(report).dump())["scenes"][0]["tested"], false);
  EXPECT_TRUE(ttest_junit(report)[0].failed);
  TTestOptions allowing;
  allowing.allow_untested = true;
  const TTestReport allowed = run_ttest(test, "t.xml", fake(), allowing);
  EXPECT_TRUE(allowed.passed());
  EXPECT_TRUE(ttest_junit(allowed)[0].skipped);
  // Samples that were thrown away are a failure, not a gap.
  Defects nan;
  nan.nan_every = 1;
  EXPECT_FALSE(run_ttest(test, "t.xml", fake(nan), allowing).passed());
}

TEST(RunTTest, ConstantEstimatorIsJudgedByTheTolerance) {
  Defects constant;
  constant.constant = true;
  const TTestReport right = run_ttest(make_test({1.5}, 1, 1, 1000), "t.xml", fake(constant));
  EXPECT_TRUE(right.passed());
  EXPECT_EQ(right.scenes[0].test.decision, Decision::numerical);
  EXPECT_THAT(ttest_table(right), HasSubstr("by tolerance"));
  EXPECT_FALSE(run_ttest(make_test({1.5003}, 1, 1, 1000), "t.xml", fake(constant)).passed());
}

TEST(RunTTest, HeavyTailsAreSaid) {
  Defects heavy;
  heavy.heavy = true;
  const TTestReport report = run_ttest(make_test({1.5}, 1, 1, 50000), "t.xml", fake(heavy));
  EXPECT_TRUE(report.scenes[0].tail.heavy());
  EXPECT_THAT(ttest_table(report), HasSubstr("heavy tail"));
  EXPECT_FALSE(run_ttest(make_test({1.5}, 1, 1, 50000), "t.xml", fake()).scenes[0].tail.heavy());
}

TEST(RunTTest, RejectedSamplesFailAndAreLocated) {
  Defects nan;
  nan.nan_every = 20000;
  const TTestReport report = run_ttest(make_test({1.5}, 2, 2, 100000), "t.xml", fake(nan));
  EXPECT_FALSE(report.passed());
  EXPECT_GT(report.scenes[0].rejected, 0u);
  EXPECT_GE(report.scenes[0].test.p_value, report.test_level) << "the mean alone would not have shown it";
  EXPECT_THAT(ttest_table(report), HasSubstr("the first at pixel ("));
}

TEST(RunTTest, CountsMustMatch) {
  TTest t = make_test({1.5, 1.5}, 1, 1, 100);
  t.references.push_back(1.0);
  try {
    run_ttest(t, "t.xml", fake());
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("3 reference(s) for 2 scene(s)"));
  }
}

TEST(RunTTest, ReportsForMachines) {
  const TTestReport report = run_ttest(make_test({1.5, 9.0}, 1, 1, 1000), "a<b>&\"c\".xml", fake());
  const nlohmann::json json = nlohmann::json::parse(ttest_json(report).dump());
  EXPECT_EQ(json["scenes"].size(), 2u);
  EXPECT_FALSE(json["passed"].get<bool>());
  EXPECT_DOUBLE_EQ(json["scenes"][1]["p"].get<double>(), report.scenes[1].test.p_value);
  const std::string xml = junit_xml("ttest", ttest_junit(report));
  EXPECT_THAT(xml, HasSubstr("tests=\"2\" failures=\"1\""));
  EXPECT_THAT(xml, HasSubstr("a&lt;b&gt;&amp;&quot;c&quot;.xml: scene 2"));
  EXPECT_THAT(xml, HasSubstr("<failure message="));
}

TEST(Junit, SkippedAndControlCharacters) {
  const std::string xml = junit_xml("s", {{"n\x01", 0.5, false, true, "no device", ""}});
  EXPECT_THAT(xml, HasSubstr("skipped=\"1\""));
  EXPECT_THAT(xml, HasSubstr("name=\"n\ufffd\""));
  EXPECT_THAT(xml, HasSubstr("<skipped message=\"no device\"/>"));
}

}  // namespace
}  // namespace etendue
