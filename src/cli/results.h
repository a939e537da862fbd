#pragma once
/// Results on stdout.

#include <string_view>
#include <utility>

#include <fmt/core.h>

#include "core/json.h"

namespace etendue::cli {

/// Writes text of whole lines to stdout, cleaned by text::printable_lines: whatever names it contains, no control
/// characters reach the terminal, and lines are cut at text::kLongestLine. A stdout that is closed, full, or a pipe
/// without a reader does not end the command, which may still have files to write; finish_results() reports it.
void print_text(std::string_view text);

template <typename... Arguments>
void print_result(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  print_text(fmt::format(format, std::forward<Arguments>(arguments)...));
}

/// Writes a value, indented by two blanks per level, and a newline; lines are never cut.
void print_json(const Json& json);

/// Makes sure that everything printed has arrived. Throws Error(file) if not.
void finish_results();

}  // namespace etendue::cli
