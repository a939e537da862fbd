// docs/scene_format.md says what the reader does: its tables are the plugin table, its examples are scenes.
// With ETENDUE_UPDATE_DOCS=1 in the environment the tables are written instead of compared.

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "formats/mitsuba/plugins.h"
#include "formats/nori/plugins.h"
#include "formats_testing.h"

namespace etendue::testing {
namespace {

const std::string kDocs = std::string(TEST_DIR) + "/../../docs/";
const std::string kPage = kDocs + "scene_format.md";
const std::string kBegin = "<!-- begin generated -->\n", kEnd = "<!-- end generated -->";

std::string read_page(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

void expect_tables(const std::string& path, const Dialect& dialect) {
  const std::string page = read_page(path);
  const std::size_t begin = page.find(kBegin), end = page.find(kEnd);
  ASSERT_NE(begin, std::string::npos) << path;
  ASSERT_NE(end, std::string::npos);
  const std::string expected =
      page.substr(0, begin + kBegin.size()) + "\n" + parameter_tables(dialect) + page.substr(end);
  if (std::getenv("ETENDUE_UPDATE_DOCS") != nullptr) {
    std::ofstream(path) << expected;
    return;
  }
  EXPECT_EQ(page, expected) << "run this test with ETENDUE_UPDATE_DOCS=1 to bring the page up to date";
}

TEST(SceneFormatPage, TablesAreThePluginTable) {
  expect_tables(kPage, nori_dialect());
}

TEST(SceneFormatPage, TablesOfMitsubaAreItsTable) {
  expect_tables(kDocs + "mitsuba.md", mitsuba_dialect());
}

TEST(SceneFormatPage, ExamplesAreValid) {
  const std::string page = read_page(kPage);
  const std::string fence = "```xml\n";
  int count = 0;
  for (std::size_t at = page.find(fence); at != std::string::npos; at = page.find(fence, at + 1), ++count) {
    const std::size_t begin = at + fence.size();
    const Parsed parsed = parse(page.substr(begin, page.find("```", begin) - begin), {{}, true});
    EXPECT_TRUE(parsed.file.has_value()) << all_messages(parsed.diagnostics);
    EXPECT_TRUE(parsed.diagnostics.list().empty()) << all_messages(parsed.diagnostics);
  }
  EXPECT_EQ(count, 4);
}

}  // namespace
}  // namespace etendue::testing
