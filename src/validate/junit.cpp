#include "validate/junit.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

std::string escape(const std::string& raw) {
  return text::xml_escaped(text::printable_lines(raw));
}

}  // namespace

std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases) {
  double seconds = 0;
  for (const JunitCase& c : cases) seconds += c.seconds;
  const auto failures = std::count_if(cases.begin(), cases.end(), [](const JunitCase& c) { return c.failed; });
  const auto skipped = std::count_if(cases.begin(), cases.end(), [](const JunitCase& c) { return c.skipped; });
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"
      "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\" time=\"{:.3f}\">\n",
      escape(suite), cases.size(), failures, skipped, seconds);
  for (const JunitCase& c : cases) {
    out += fmt::format("  <testcase name=\"{}\" classname=\"{}\" time=\"{:.3f}\">\n", escape(c.name), escape(suite),
                       c.seconds);
    if (c.failed) out += fmt::format("    <failure message=\"{}\"/>\n", escape(c.message));
    if (c.skipped) out += fmt::format("    <skipped message=\"{}\"/>\n", escape(c.message));
    if (!c.details.empty()) out += fmt::format("    <system-out>{}</system-out>\n", escape(c.details));
    out += "  </testcase>\n";
  }
  return out + "</testsuite>\n</testsuites>\n";
}

}  // namespace etendue
