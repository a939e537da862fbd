#include "cli/result_files.h"

#include <span>

#include "cli/overwrite.h"
#include "image/files.h"

namespace etendue::cli {

void ResultFiles::add_to(Command& command, bool with_html) {
  command.add_option("--json", json, "write the results as JSON to this file");
  command.add_option("--junit", junit, "write the results as JUnit XML to this file");
  if (with_html) command.add_option("--html", html, "write a self-contained report for any browser to this file");
}

void ResultFiles::check() const {
  check_distinct({{"--json", json}, {"--junit", junit}, {"--html", html}});
  for (const auto& [option, path] : {NamedFile("--json", json), {"--junit", junit}, {"--html", html}}) {
    if (path.empty()) continue;
    check_report_replaceable(option, path);
    check_writable(path);
  }
}

void write_text(OutputWriter& files, const std::string& path, const std::function<std::string()>& text) {
  if (path.empty()) return;
  files.write(path, [&] {
    const std::string content = text();
    write_file_atomically(path, std::as_bytes(std::span(content)));
  });
}

}  // namespace etendue::cli
