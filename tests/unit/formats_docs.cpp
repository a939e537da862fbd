// docs/scene_format.md says what the reader does: its tables are the plugin table, its examples are scenes.
// With ETENDUE_UPDATE_DOCS=1 in the environment the tables are written instead of compared.

#include <algorithm>
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

std::size_t characters(const std::string& utf8) {
  return std::ranges::count_if(utf8, [](char c) { return (c & 0xc0) != 0x80; });
}

// At the start of a line it would make a list of what follows.
bool begins_list(const std::string& word) {
  return word == "-" || word == "+" || word == "*" ||
         (word.ends_with('.') && word.find_first_not_of("0123456789") == word.size() - 1);
}

// Lines of prose of at most 120 characters; tables and headings stay as they are.
std::string with_short_lines(const std::string& page) {
  constexpr std::size_t kLongest = 120;
  std::string out;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    std::string start;
    if (!line.starts_with('|') && !line.starts_with('#')) {
      std::istringstream words(line);
      for (std::string word; words >> word;) {
        if (!start.empty() && characters(start) + 1 + characters(word) > kLongest && !begins_list(word)) {
          out += start + "\n";
          start.clear();
        }
        start += (start.empty() ? "" : " ") + word;
      }
      line = start;
    }
    out += line + "\n";
  }
  return out;
}

void expect_tables(const std::string& path, const Dialect& dialect) {
  const std::string page = read_page(path);
  const std::size_t begin = page.find(kBegin), end = page.find(kEnd);
  ASSERT_NE(begin, std::string::npos) << path;
  ASSERT_NE(end, std::string::npos);
  const std::string expected =
      page.substr(0, begin + kBegin.size()) + "\n" + with_short_lines(parameter_tables(dialect)) + page.substr(end);
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
