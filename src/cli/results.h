#pragma once
/// Results on stdout.

#include <string_view>
#include <utility>

#include <fmt/core.h>

#include "core/json.h"

namespace etendue::cli {

/// Writes text of whole lines to stdout, cleaned by text::printable_lines: whatever names it holds, no control
/// characters reach the terminal, and lines are cut at text::kLongestLine. A stdout that is closed, full, or a pipe
/// without a reader does not end the command, which may have files to write yet; finish_results() tells.
void print_text(std::string_view text);

template <typename... Arguments>
void print_result(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  print_text(fmt::format(format, std::forward<Arguments>(arguments)...));
}

/// Writes a value, two blanks a level, and a newline; never cut.
void print_json(const Json& json);

/// What was printed is with its receiver now. Throws Error(file) unless all of it is.
void finish_results();

}  // namespace etendue::cli
