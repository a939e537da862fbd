#pragma once
/// Results beside stdout: --json, --html and --junit of the testing commands.

#include <string>

#include "core/command_line.h"

namespace etendue::cli {

struct ResultFiles {
  std::string json, html, junit;  ///< paths; empty: not wanted

  /// Adds --json, --junit and, where the command has one, --html.
  void add_to(Command& command, bool with_html);
};

/// Writes the whole file or leaves the path as it was. Throws Error(file_error).
void write_text(const std::string& path, const std::string& text);

}  // namespace etendue::cli
