#include "cli/result_files.h"

#include <span>

#include "cli/overwrite.h"
#include "cli/results.h"
#include "core/log.h"
#include "image/files.h"

namespace etendue::cli {
namespace {

constexpr const char* kSection = "Results";
constexpr const char* kStdout = "-";

}  // namespace

void ResultOptions::add_to(Command& command) {
  command
      .add_flag("-q,--quiet", quiet,
                "no notes, progress or tables; warnings, errors, files, --json and the exit code remain")
      ->group(kSection);
  command
      .add_optional_value("--json", json, "FILE",
                          "print the results as JSON instead of text, or write them to this file in addition")
      ->file({".json"})
      ->group(kSection);
}

void ResultOptions::add_junit(Command& command) {
  command.add_option("--junit", junit, "write the results as JUnit XML to this file")->file({".xml"})->group(kSection);
}

void ResultOptions::add_html(Command& command) {
  command.add_option("--html", html, "write a self-contained report for any browser to this file")
      ->file({".html"})
      ->group(kSection);
}

std::vector<NamedFile> ResultOptions::named_files() const {
  return {{"--json", json == kStdout ? "" : json}, {"--junit", junit}, {"--html", html}};
}

void ResultOptions::begin() const {
  if (quiet) log::set_level(log::Level::warning);
  const std::vector<NamedFile> files = named_files();
  check_distinct(files);
  for (const auto& [option, path] : files) {
    if (path.empty()) continue;
    check_report_replaceable(option, path);
    check_writable(path);
  }
}

void ResultOptions::write_json(OutputWriter& files, const std::function<Json()>& content) const {
  if (json == kStdout) {
    print_json(content());
  } else {
    write_text(files, json, [&] { return content().dump(2) + "\n"; });
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
