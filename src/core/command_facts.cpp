#include "core/command_facts.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/text.h"

namespace etendue {
namespace {

constexpr std::size_t kLineLength = 80;
constexpr std::size_t kTextColumn = 28;  // where descriptions begin

// The number of characters; continuation bytes of UTF-8 do not count.
std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

// Appends the words of `text`, which begin at column `at`; further lines begin at column `indent`.
void add_wrapped(std::string& out, std::string_view text, std::size_t at, std::size_t indent) {
  bool first = true;
  for (const std::string_view word : text::split(text, ' ')) {
    if (word.empty()) continue;
    if (!first && at + 1 + width_of(word) > kLineLength) {
      out += "\n" + std::string(indent, ' ');
      at = indent;
    } else if (!first) {
      out += ' ';
      ++at;
    }
    out += word;
    at += width_of(word);
    first = false;
  }
  out += '\n';
}

// "  -o, --output FILE     image to write"; if the names are long, the description starts on a new line.
void add_row(std::string& out, const std::string& heading, const std::string& description) {
  std::string start = "  " + heading;
  std::size_t at = width_of(start);
  if (!description.empty()) {
    start += at + 2 <= kTextColumn ? std::string(kTextColumn - at, ' ') : "\n" + std::string(kTextColumn, ' ');
    at = kTextColumn;
  }
  out += start;
  add_wrapped(out, description, at, kTextColumn);
}

std::string description_of(const OptionFacts& option) {
  if (option.default_text.empty()) return option.description;
  return fmt::format("{} (default: {})", option.description, option.default_text);
}

}  // namespace

std::string heading_of(const OptionFacts& option) {
  if (option.is_positional()) return option.value + (option.repeatable ? "..." : "");
  std::string out = fmt::format("{}", fmt::join(option.names, ", "));
  if (option.value.empty()) return out;
  return out + (option.value_optional ? "[=" + option.value + "]" : " " + option.value);
}

std::string synopsis_of(const CommandFacts& command) {
  std::string out = command.commands.empty() ? "[OPTIONS]" : "COMMAND [OPTIONS]";
  for (const OptionFacts& option : command.options) {
    if (!option.is_positional()) continue;
    const std::string word = heading_of(option);
    out += option.required ? " " + word : " [" + word + "]";
  }
  return out;
}

std::vector<OptionSection> sections_of(const CommandFacts& command) {
  std::vector<OptionSection> out = {{"Arguments", {}}};
  for (const OptionFacts& option : command.options) {
    if (option.hidden) continue;
    const std::string name = option.is_positional() ? "Arguments" : option.section.empty() ? "Options" : option.section;
    auto section = std::ranges::find(out, name, &OptionSection::name);
    if (section == out.end()) section = out.insert(out.end(), {name, {}});
    section->options.push_back(&option);
  }
  if (out.front().options.empty()) out.erase(out.begin());
  return out;
}

std::string help_text(const CommandFacts& command) {
  std::string out;
  add_wrapped(out, command.full_name + ": " + command.description, 0, 0);
  out += "\n";
  add_wrapped(out, fmt::format("Usage: {} {}", command.full_name, synopsis_of(command)), 0, 7);
  if (!command.commands.empty()) out += "\nCommands:\n";
  for (const CommandFacts& sub : command.commands) add_row(out, sub.name, sub.description);
  for (const OptionSection& section : sections_of(command)) {
    out += fmt::format("\n{}:\n", section.name);
    for (const OptionFacts* option : section.options) add_row(out, heading_of(*option), description_of(*option));
  }
  for (const std::string_view paragraph : text::split(command.footer, '\n')) {
    out += "\n";
    add_wrapped(out, paragraph, 0, 0);
  }
  return out;
}

}  // namespace etendue
