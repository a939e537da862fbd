#pragma once
/// What a command tells and where: -q, --json, --html and --junit mean the same in every command that has them.

#include <functional>
#include <string>

#include "cli/outputs.h"
#include "core/command_line.h"
#include "core/json.h"

namespace etendue::cli {

struct ResultOptions {
  bool quiet = false;       ///< no notes, no progress, no tables
  std::string json;         ///< a path, "-" for stdout, or empty
  std::string html, junit;  ///< paths; empty: not wanted

  /// Adds -q and --json.
  void add_to(Command& command);
  void add_junit(Command& command);
  void add_html(Command& command);

  /// To be called before the work. Lets the log know about -q. Throws Error(usage) when two names are one file,
  /// Error(file) when one could not be written, or is none of our reports.
  void begin() const;
  /// The files and the options that name them.
  std::vector<NamedFile> named_files() const;

  /// Whether a person is to get the results as text on stdout: unless they get JSON there, or nothing.
  bool wants_text() const { return !quiet && json != "-"; }

  /// JSON to stdout or to the file, where it is wanted; what fails is kept for OutputWriter::finish().
  void write_json(OutputWriter& files, const std::function<Json()>& json) const;
};

/// Writes what `text` returns to `path`, whole or not at all; nothing when the path is empty. What fails is kept for
/// OutputWriter::finish().
void write_text(OutputWriter& files, const std::string& path, const std::function<std::string()>& text);

}  // namespace etendue::cli
