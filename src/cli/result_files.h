#pragma once
/// The outputs of a command: -q, --json, --html and --junit mean the same in every command that has them.

#include <functional>
#include <string>

#include "cli/outputs.h"
#include "core/command_line.h"
#include "core/json.h"

namespace etendue::cli {

struct ResultOptions {
  bool quiet = false;       ///< no notes, no progress, no tables
  std::string json;         ///< a path, "-" for stdout, or empty
  std::string html, junit;  ///< paths; empty if not requested

  /// Adds -q and --json.
  void add_to(Command& command);
  void add_junit(Command& command);
  void add_html(Command& command);

  /// To be called before the work. Passes -q on to the log. Throws Error(usage) if two names are the same file,
  /// Error(file) if one cannot be written, or exists and is not an earlier report.
  void begin() const;
  /// The files and the options that name them.
  std::vector<NamedFile> named_files() const;

  /// Whether the results are printed as text: unless stdout gets JSON, or -q was given.
  bool wants_text() const { return !quiet && json != "-"; }

  /// Writes JSON to stdout or to the file, if requested; failures are kept for OutputWriter::finish().
  void write_json(OutputWriter& files, const std::function<Json()>& json) const;
};

/// Writes the result of `text` to `path`, completely or not at all; does nothing if the path is empty. Failures are
/// kept for OutputWriter::finish().
void write_text(OutputWriter& files, const std::string& path, const std::function<std::string()>& text);

}  // namespace etendue::cli
