#pragma once
/// Results beside stdout: --json, --html and --junit of the testing commands.

#include <functional>
#include <string>

#include "cli/outputs.h"
#include "core/command_line.h"

namespace etendue::cli {

struct ResultFiles {
  std::string json, html, junit;  ///< paths; empty: not wanted

  /// Adds --json, --junit and, where the command has one, --html.
  void add_to(Command& command, bool with_html);

  /// Throws Error(usage) when two names are one file, Error(file) when one could not be written: better before
  /// the tests than after them.
  void check() const;
};

/// Writes what `text` returns to `path`, whole or not at all; nothing when the path is empty. What fails is kept for
/// OutputWriter::finish().
void write_text(OutputWriter& files, const std::string& path, const std::function<std::string()>& text);

}  // namespace etendue::cli
