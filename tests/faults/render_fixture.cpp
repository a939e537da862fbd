#include "render_fixture.h"

#include <regex>

namespace etendue::faults {

std::string RenderTest::samples_of(const std::string& film) const {
  const ProcessResult result = run({"merge", film, "-o", "samples-of.png", "--json", "--force"});
  std::smatch match;
  const bool found = std::regex_search(result.out, match, std::regex("\"samples\": ([0-9]+)"));
  return found ? match[1].str() : "0";
}

}  // namespace etendue::faults
