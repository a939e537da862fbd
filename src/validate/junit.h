#pragma once
/// Results in the JUnit XML dialect that CI systems show.

#include <string>
#include <vector>

namespace etendue {

struct JunitCase {
  std::string name;
  double seconds = 0;
  bool failed = false;
  bool skipped = false;
  std::string message;  ///< one line: why it failed or was skipped
  std::string details;  ///< the numbers; shown as system-out
};

/// One `<testsuite>` document (UTF-8). Control characters and bytes that are not UTF-8, which XML cannot
/// hold, become U+FFFD; long lines are cut.
std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases);

}  // namespace etendue
