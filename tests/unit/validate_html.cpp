// What a report file must be before any browser sees it: complete, self-contained and safe against the names inside it.

#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "validate/html_report.h"

namespace etendue {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Base64, TestVectorsOfRfc4648) {
  const std::pair<std::string, std::string> cases[] = {{"", ""},
                                                       {"f", "Zg=="},
                                                       {"fo", "Zm8="},
                                                       {"foo", "Zm9v"},
                                                       {"foob", "Zm9vYg=="},
                                                       {"fooba", "Zm9vYmE="},
                                                       {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, encoded] : cases) EXPECT_EQ(base64(plain.data(), plain.size()), encoded);
}

TEST(ScriptJson, CannotCloseItsElement) {
  const std::string text = script_json({{"name", "</script><script>alert(1)</script>"}, {"bad", "\xff"}});
  EXPECT_THAT(text, Not(HasSubstr("<")));
  EXPECT_EQ(nlohmann::json::parse(text)["name"], "</script><script>alert(1)</script>");
}

TEST(Report, OfALargePictureHoldsMeansAndTheWorstScores) {
  Image a;
  a.width = 1001;
  a.height = 900;
  a.pixels.assign(std::size_t{a.width} * a.height, glm::vec3(1.0f));
  a.standard_error.assign(a.pixels.size(), glm::vec3(0.1f));
  a.sample_count.assign(a.pixels.size(), 64);
  Image b = a;
  b.pixels[1] = glm::vec3(3.0f);  // the right one of the first square: mean 1.5, and a score beyond doubt
  CompareOptions options;
  options.metrics.flip = false;
  const std::string html = comparison_html(compare_images(a, "a.exr", b, "b.exr", options), a, b);
  EXPECT_LT(html.size(), 20u << 20);
  EXPECT_THAT(html, HasSubstr("\"reduction\":2"));
  EXPECT_THAT(html, HasSubstr("\"width\":501"));
  EXPECT_THAT(html, HasSubstr("\"fullWidth\":1001"));
  const std::vector<glm::vec3> first = {glm::vec3(1.5f), glm::vec3(1.0f)};
  EXPECT_THAT(html, HasSubstr(fmt::format(">{}", base64(first.data(), 24))));
  const std::vector<glm::vec3> scores = pixel_scores(a, b, 2);
  ASSERT_EQ(scores.size(), 501u * 450);
  EXPECT_LT(scores[0].x, -5.0f);
  EXPECT_EQ(scores[0].x, pixel_scores(a, b)[1].x);
  EXPECT_EQ(scores[1].x, 0.0f);
}

TEST(Report, HoldsTheFloatsAndNoPlaceholder) {
  Image a;
  a.width = 2;
  a.height = 1;
  a.pixels = {{0.1f, 0.2f, 0.3f}, {1e-30f, -4.0f, std::nanf("")}};
  a.metadata = {{"comment", "@PIXELS_B@ @DATA@"}};  // must not be filled in
  Image b = a;
  b.metadata.clear();
  CompareOptions options;
  options.metrics.flip = false;
  const std::string html = comparison_html(compare_images(a, "@JS@.exr", b, "b.exr", options), a, b);
  EXPECT_THAT(html, HasSubstr(base64(a.pixels.data(), 24)));
  EXPECT_THAT(html, HasSubstr("@PIXELS_B@ @DATA@"));
  EXPECT_THAT(html, HasSubstr("<title>@JS@.exr against b.exr</title>"));
  for (const char* name : {"@CSS@", "@SCORES@", "@PIXELS_A@"}) EXPECT_THAT(html, Not(HasSubstr(name)));
  for (const char* network : {"src=\"http", "href=", "@import", "url("}) EXPECT_THAT(html, Not(HasSubstr(network)));
  EXPECT_THAT(html, HasSubstr("</html>"));
}

}  // namespace
}  // namespace etendue
