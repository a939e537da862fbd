// Comparing pictures: false-alarm rates by simulation, power, negative controls, limits and reports.

#include "validate/compare.h"

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/errors.h"

namespace etendue {
namespace {

using ::testing::HasSubstr;

enum class Noise { exponential, coin, rare };

// A picture as a renderer makes it: `spp` samples per pixel of expectation `factor` · (1 + x/width).
Image picture(std::uint32_t width, std::uint32_t height, std::uint32_t spp, unsigned seed, double factor = 1.0,
              Noise noise = Noise::exponential) {
  std::mt19937_64 rng(seed);
  std::exponential_distribution<double> exponential(1.0);
  std::bernoulli_distribution coin(0.5), rare(0.01);
  Image image;
  image.width = width;
  image.height = height;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    const double expectation = factor * (1.0 + double(i % width) / width);
    glm::vec3 mean, error;
    for (int c = 0; c < 3; ++c) {
      RunningMoments m;
      for (std::uint32_t s = 0; s < spp; ++s) {
        m.add(expectation * (noise == Noise::coin   ? 2.0 * coin(rng)
                             : noise == Noise::rare ? 100.0 * rare(rng)
                                                    : exponential(rng)));
      }
      mean[c] = float(m.mean());
      error[c] = float(m.standard_error());
    }
    image.pixels.push_back(mean);
    image.standard_error.push_back(error);
    image.sample_count.push_back(spp);
  }
  image.metadata = {{"seed", std::to_string(seed)}, {"samples", std::to_string(spp)}};
  return image;
}

CompareOptions without_flip() {
  CompareOptions options;
  options.metrics.flip = false;
  return options;
}

Comparison compare(const Image& a, const Image& b, const CompareOptions& options = without_flip()) {
  return compare_images(a, "a.exr", b, "b.exr", options);
}

TEST(Compare, IndependentRendersAreStatisticallyEqual) {
  const Comparison c = compare(picture(32, 24, 64, 1), picture(32, 24, 64, 2));
  EXPECT_EQ(c.verdict, Verdict::statistically_equal) << comparison_text(c);
  EXPECT_TRUE(c.passed());
  ASSERT_EQ(c.tests->families.size(), 3u);
  EXPECT_EQ(c.tests->families[0].tests, 32u * 24 * 3);
  EXPECT_EQ(c.tests->families[1].tests, 4u * 3 * 3);
  EXPECT_EQ(c.tests->families[2].tests, 3u);
  EXPECT_NEAR(c.tests->families[0].z_mean, 0.0, 0.1);
  EXPECT_NEAR(c.tests->families[0].z_deviation, 1.0, 0.05);
  ASSERT_EQ(c.metadata.size(), 1u);
  EXPECT_EQ(c.metadata[0].name, "seed");
}

// Family-wise rates over simulated pairs: at most what is stated, for skewed samples and for coins, whose variance
// vanishes by chance.
class CompareRate : public ::testing::TestWithParam<std::pair<Noise, std::uint32_t>> {};
TEST_P(CompareRate, FalseAlarmsStayBelowTheStatedRate) {
  const auto [noise, spp] = GetParam();
  constexpr std::uint64_t kExperiments = 300;
  std::uint64_t alarms = 0;
  for (std::uint32_t i = 0; i < kExperiments; ++i) {
    const Image a = picture(16, 16, spp, 2 * i, 1.0, noise), b = picture(16, 16, spp, 2 * i + 1, 1.0, noise);
    alarms += !test_images(a, b, 0.05).passed();
  }
  EXPECT_GT(binomial_upper_tail(alarms, kExperiments, 0.05), 1e-3) << alarms << " of " << kExperiments;
}
INSTANTIATE_TEST_SUITE_P(Noise, CompareRate,
                         ::testing::Values(std::pair{Noise::exponential, 16u}, std::pair{Noise::exponential, 4u},
                                           std::pair{Noise::coin, 16u}, std::pair{Noise::coin, 3u}));

TEST(Compare, ABiasIsFoundAtTheSizeItPromises) {
  const Image reference = picture(32, 24, 64, 1);
  const double detectable = compare(picture(32, 24, 64, 2), reference).tests->detectable_bias;
  EXPECT_GT(detectable, 0.005);
  EXPECT_LT(detectable, 0.05);
  int found = 0;
  for (unsigned i = 0; i < 20; ++i) {
    found += compare(picture(32, 24, 64, 100 + i, 1.0 + detectable), reference).verdict == Verdict::different;
  }
  EXPECT_GE(found, 17);  // 0.99 each, but all share one noisy reference
}

TEST(Compare, OneWrongPixelAndOneWrongBlockAreFound) {
  const Image reference = picture(32, 24, 64, 1);
  Image pixel = picture(32, 24, 64, 2);
  pixel.pixels[5 * 32 + 7].y *= 3.0f;
  const Comparison c = compare(pixel, reference);
  EXPECT_EQ(c.verdict, Verdict::different);
  EXPECT_FALSE(c.tests->families[0].passed());
  EXPECT_EQ(c.tests->families[0].worst_x, 7u);
  EXPECT_EQ(c.tests->families[0].worst_y, 5u);
  EXPECT_EQ(c.tests->families[0].worst_channel, 1);
  EXPECT_GE(c.tests->families[0].rejected, 1u);
  Image block = picture(32, 24, 64, 3);
  for (std::uint32_t y = 8; y < 16; ++y) {
    for (std::uint32_t x = 16; x < 24; ++x) block.pixels[y * 32 + x] *= 1.15f;
  }
  const Comparison d = compare(block, reference);
  EXPECT_FALSE(d.tests->families[1].passed());
  EXPECT_EQ(d.tests->families[1].worst_x, 16u);
  EXPECT_EQ(d.tests->families[1].worst_y, 8u);
}

TEST(Compare, IdenticalAndUntestedAndNan) {
  Image a = picture(8, 8, 16, 1);
  EXPECT_EQ(compare(a, a).verdict, Verdict::identical);
  Image bare = a;
  bare.standard_error.clear();
  bare.pixels[0].x += 1.0f;
  EXPECT_EQ(compare(bare, a).verdict, Verdict::untested);
  EXPECT_FALSE(compare(bare, a).passed());
  a.pixels[0].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(compare(a, a).verdict, Verdict::different);
  EXPECT_FALSE(compare(a, a).passed());
}

// What a file says of its errors and samples, for a picture twice as bright as the other.
struct Claim {
  const char* name;
  float error;  // relative
  std::uint32_t samples;
  Verdict verdict;
};
class CompareClaims : public ::testing::TestWithParam<Claim> {};
TEST_P(CompareClaims, TwiceAsBrightIsNeverEqual) {
  const Claim& claim = GetParam();
  Image a = picture(16, 16, 2, 1), b = a;
  for (Image* image : {&a, &b}) {
    for (std::size_t i = 0; i < image->pixels.size(); ++i) {
      if (image == &a) image->pixels[i] *= 2.0f;
      image->standard_error[i] = image->pixels[i] * claim.error;
      image->sample_count[i] = claim.samples;
    }
  }
  const Comparison c = compare(a, b);
  EXPECT_EQ(c.verdict, claim.verdict) << comparison_text(c);
  EXPECT_FALSE(c.passed());
  EXPECT_TRUE(comparison_junit(c).failed);
  CompareOptions allowing = without_flip();
  allowing.allow_untested = true;
  EXPECT_EQ(compare(a, b, allowing).passed(), claim.verdict == Verdict::untested);
  // With an error in one picture only there is no test either.
  if (claim.verdict == Verdict::untested) {
    const Comparison half = compare(a, picture(16, 16, 64, 3));
    EXPECT_EQ(half.verdict, Verdict::untested) << comparison_text(half);
  }
}
constexpr float kInfinite = std::numeric_limits<float>::infinity(), kNan = std::numeric_limits<float>::quiet_NaN();
INSTANTIATE_TEST_SUITE_P(Errors, CompareClaims,
                         ::testing::Values(Claim{"zero_of_one_sample", 0.0f, 1, Verdict::untested},
                                           Claim{"zero_of_none", 0.0f, 0, Verdict::untested},
                                           Claim{"zero_of_many", 0.0f, 64, Verdict::different},
                                           Claim{"infinite", kInfinite, 1, Verdict::untested},
                                           Claim{"infinite_of_many", kInfinite, 64, Verdict::untested},
                                           Claim{"nan", kNan, 64, Verdict::untested},
                                           Claim{"negative", -0.01f, 64, Verdict::untested},
                                           Claim{"immense", 1e20f, 64, Verdict::untested}),
                         [](const auto& claim) { return claim.param.name; });

TEST(Compare, OneSampleAPixelIsNotTested) {
  const Comparison c = compare(picture(16, 16, 1, 1), picture(16, 16, 1, 2));
  EXPECT_EQ(c.verdict, Verdict::untested);
  EXPECT_THAT(comparison_text(c), HasSubstr("256 of 256 pixels differ where there is no standard error"));
  EXPECT_EQ(nlohmann::json::parse(comparison_json(c).dump())["verdict"], "not tested");
  // The limits are the test then, if there are any.
  CompareOptions options = without_flip();
  options.limits = {parse_limit("rmse=1e3", true)};
  EXPECT_TRUE(compare(picture(16, 16, 1, 1), picture(16, 16, 1, 2), options).passed());
  options.limits = {parse_limit("rmse=1e-3", true)};
  EXPECT_FALSE(compare(picture(16, 16, 1, 1), picture(16, 16, 1, 2), options).passed());
}

TEST(Compare, OnePixelThatCannotBeTestedSpoilsTheVerdictOnlyIfItDiffers) {
  const Image reference = picture(32, 24, 64, 1);
  Image hole = picture(32, 24, 64, 2);
  hole.sample_count[100] = 0;
  hole.standard_error[100] = glm::vec3(kInfinite);
  EXPECT_EQ(compare(hole, reference).verdict, Verdict::untested);
  EXPECT_EQ(compare(hole, reference).tests->untested, 1u);
  hole.pixels[100] = reference.pixels[100];
  EXPECT_EQ(compare(hole, reference).verdict, Verdict::statistically_equal);
  // A difference that a test finds elsewhere is one whatever else is unknown.
  hole.pixels[100] *= 2.0f;
  hole.pixels[200] *= 5.0f;
  EXPECT_EQ(compare(hole, reference).verdict, Verdict::different);
}

TEST(Compare, ATestThatCannotRejectIsNone) {
  // Two samples of one pixel: no difference is beyond what chance allows.
  Image a = picture(1, 1, 2, 1), b = a;
  b.pixels[0] *= 50.0f;
  const Comparison c = compare(a, b);
  EXPECT_EQ(c.verdict, Verdict::untested) << comparison_text(c);
  EXPECT_THAT(comparison_text(c), HasSubstr("the noise hides everything below"));
}

// 1 against 1.3, with an error so large that no test of the difference rejects.
Image even(std::uint32_t side, float value, float error) {
  Image image;
  image.width = image.height = side;
  image.pixels.assign(std::size_t{side} * side, glm::vec3(value));
  image.standard_error.assign(image.pixels.size(), glm::vec3(error));
  image.sample_count.assign(image.pixels.size(), 64);
  return image;
}

TEST(Compare, ErrorsThatAreFarTooLargeAreNotBelieved) {
  for (const auto& [side, error] :
       {std::pair{64u, 5.0f}, std::pair{40u, 5.0f}, std::pair{16u, 1.5f}, std::pair{12u, 1.0f}}) {
    SCOPED_TRACE(side);
    const Image a = even(side, 1.0f, error), b = even(side, 1.3f, error);
    const Comparison c = compare(a, b);
    EXPECT_TRUE(c.tests->passed());
    EXPECT_LE(c.tests->detectable_bias, kBlindBias);
    EXPECT_EQ(c.verdict, Verdict::untested) << comparison_text(c);
    EXPECT_FALSE(c.passed());
    EXPECT_THAT(c.untested_why, HasSubstr("the errors are too large, or the pictures share their noise"));
    EXPECT_TRUE(nlohmann::json::parse(comparison_json(c).dump())["tests"]["errorsTooLarge"].get<bool>());
    EXPECT_EQ(compare(a, a).verdict, Verdict::identical);
  }
}

TEST(Compare, ErrorsThatAreTooLargeInAPartAreNotBelieved) {
  Image a = picture(64, 96, 64, 1), b = picture(64, 96, 64, 2);
  for (std::uint32_t y = 0; y < 32; ++y) {
    for (std::uint32_t x = 32; x < 64; ++x) {
      b.pixels[y * 64 + x] = a.pixels[y * 64 + x] * 1.1f;
      for (Image* image : {&a, &b}) image->standard_error[y * 64 + x] *= 20.0f;
    }
  }
  const Comparison c = compare(a, b);
  EXPECT_EQ(c.verdict, Verdict::untested) << comparison_text(c);
  EXPECT_THAT(c.untested_why, HasSubstr("in the 32x32 pixels from (32, 0) on"));
}

TEST(Compare, SameSeedExplainsScoresThatAreTooSmall) {
  Image a = picture(32, 32, 64, 1), b = a;
  for (glm::vec3& pixel : b.pixels) pixel *= 1.0001f;
  EXPECT_EQ(compare(a, b).verdict, Verdict::untested);
  a.metadata["sceneHash"] = b.metadata["sceneHash"] = "17";
  EXPECT_EQ(compare(a, b).verdict, Verdict::statistically_equal);
  b.metadata["seed"] = "2";
  EXPECT_EQ(compare(a, b).verdict, Verdict::untested);
  // What a test finds is a difference all the same.
  for (glm::vec3& pixel : b.pixels) pixel *= 1.2f;
  EXPECT_EQ(compare(a, b).verdict, Verdict::different);
}

// Noise, samples of A, samples of B.
class SpreadRate : public ::testing::TestWithParam<std::tuple<Noise, std::uint32_t, std::uint32_t>> {};
TEST_P(SpreadRate, FalseAlarmsStayBelowTheBound) {
  const auto [noise, samples_a, samples_b] = GetParam();
  constexpr std::uint64_t kExperiments = 300;
  std::uint64_t alarms = 0;
  for (std::uint32_t i = 0; i < kExperiments; ++i) {
    const Image a = picture(8, 8, samples_a, 2 * i, 1.0, noise), b = picture(8, 8, samples_b, 2 * i + 1, 1.0, noise);
    const ScoreSpread spread = score_spread(a, b);
    EXPECT_FALSE(spread.too_small);
    // Without the factor of 2 that is allowed for.
    alarms += mean_lower_tail_bound(spread.mean_square, spread.pixels, 3.0) < 0.05;
  }
  EXPECT_GT(binomial_upper_tail(alarms, kExperiments, 0.05), 1e-3) << alarms << " of " << kExperiments;
}
INSTANTIATE_TEST_SUITE_P(Noise, SpreadRate,
                         ::testing::Values(std::tuple{Noise::exponential, 16u, 16u}, std::tuple{Noise::coin, 2u, 2u},
                                           std::tuple{Noise::coin, 16u, 16u}, std::tuple{Noise::rare, 64u, 64u},
                                           std::tuple{Noise::exponential, 2u, 2u}, std::tuple{Noise::rare, 16u, 160u},
                                           std::tuple{Noise::exponential, 2u, 160u},
                                           std::tuple{Noise::coin, 2u, 1600u}));

TEST(Compare, SharedSeedIsNoted) {
  Image a = picture(8, 8, 64, 1), b = picture(8, 8, 64, 1, 1.0001);
  a.metadata["sceneHash"] = b.metadata["sceneHash"] = "17";
  ASSERT_FALSE(compare(a, b).notes.empty());
  EXPECT_THAT(compare(a, b).notes[0], HasSubstr("same seed"));
}

TEST(Compare, TooFewSamplesForPixelsAreLeftToTheBlocks) {
  const Comparison c = compare(picture(16, 16, 4, 1), picture(16, 16, 4, 2));
  EXPECT_EQ(c.tests->families[0].tests, 0u);
  EXPECT_EQ(c.tests->families[0].skipped, 16u * 16 * 3);
  EXPECT_GT(c.tests->families[1].tests, 0u);
  EXPECT_THAT(comparison_text(c), HasSubstr("each needs 16 samples"));
  EXPECT_EQ(compare(picture(16, 16, 4, 1, 1.2), picture(16, 16, 4, 2)).verdict, Verdict::different);
}

TEST(Limits, ParsedAndKept) {
  const Image a = picture(8, 8, 16, 1), b = picture(8, 8, 16, 2);
  CompareOptions options = without_flip();
  options.limits = {parse_limit("rmse=1e3", true), parse_limit("mse=1e-9", true), parse_limit("psnr=1", false)};
  const Comparison c = compare(a, b, options);
  EXPECT_TRUE(c.limits[0].kept);
  EXPECT_FALSE(c.limits[1].kept);
  EXPECT_TRUE(c.limits[2].kept);
  EXPECT_FALSE(c.passed());
  // A limit on FLIP computes it although it was left out.
  options.limits = {parse_limit("flip=1e-6", true)};
  EXPECT_FALSE(compare(a, b, options).passed());
}

TEST(Limits, MistakesAreNamed) {
  const auto message = [](const std::string& text, bool upper) -> std::string {
    try {
      parse_limit(text, upper);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::usage);
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("rsme=1", true), HasSubstr("metric out of mse, rmse"));
  EXPECT_THAT(message("rmse", true), HasSubstr("METRIC=VALUE"));
  EXPECT_THAT(message("rmse=1x", true), HasSubstr("'1x' is not a number"));
  EXPECT_THAT(message("rmse=", true), HasSubstr("is not a number"));
  EXPECT_THAT(message("rmse=nan", true), HasSubstr("is not a number"));
  EXPECT_THAT(message("psnr=30", true), HasSubstr("use --fail-below"));
  EXPECT_THAT(message("rmse=30", false), HasSubstr("use --fail-above"));
}

TEST(Compare, JsonSaysTheSame) {
  const Comparison c = compare(picture(16, 16, 64, 1, 1.5), picture(16, 16, 64, 2));
  const nlohmann::json json = nlohmann::json::parse(comparison_json(c).dump());
  EXPECT_EQ(json["verdict"], "different");
  EXPECT_DOUBLE_EQ(json["metrics"]["rmse"].get<double>(), c.metrics.rmse);
  EXPECT_EQ(json["tests"]["families"].size(), 3u);
  EXPECT_TRUE(json["metrics"]["flip"].is_null());
  EXPECT_TRUE(comparison_junit(c).failed);
  EXPECT_FALSE(comparison_junit(compare(picture(8, 8, 64, 1), picture(8, 8, 64, 2))).failed);
  EXPECT_EQ(json_text({{"x", "\xff"}}), "{\n  \"x\": \"\xef\xbf\xbd\"\n}\n");
}

}  // namespace
}  // namespace etendue
