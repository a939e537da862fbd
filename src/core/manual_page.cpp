/// The manual page of a program, from the table of its options.

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "core/command_facts.h"
#include "core/text.h"

namespace etendue {
namespace {

/// Text that roff prints literally: no escapes, no requests, and dashes that can be copied into a shell.
std::string roff(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool line_begins = i == 0 || text[i - 1] == '\n';
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else {
      out += c;
    }
  }
  return out;
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// "\fB\-o\fR, \fB\-\-output\fR \fIFILE\fR".
std::string heading(const OptionFacts& option) {
  if (option.is_positional()) return fmt::format("\\fI{}\\fR", roff(heading_of(option)));
  std::string out;
  for (const std::string& name : option.names) out += fmt::format("{}\\fB{}\\fR", out.empty() ? "" : ", ", roff(name));
  if (option.value.empty()) return out;
  if (option.value_optional) return fmt::format("{}[=\\fI{}\\fR]", out, roff(option.value));
  return fmt::format("{} \\fI{}\\fR", out, roff(option.value));
}

void add_paragraphs(std::string& out, const std::string& text) {
  for (const std::string_view paragraph : text::split(text, '\n'))
    out += fmt::format(".PP\n{}\n", roff(std::string(paragraph)));
}

void add_options(std::string& out, const CommandFacts& command, bool with_names) {
  for (const OptionSection& section : sections_of(command)) {
    if (with_names && section.name != "Options") out += fmt::format(".PP\n\\fI{}\\fR\n", roff(section.name));
    for (const OptionFacts* option : section.options) {
      const std::string preset =
          option->default_text.empty() ? "" : fmt::format(" (default: {})", option->default_text);
      out += fmt::format(".TP\n{}\n{}\n", heading(*option), roff(option->description + preset));
    }
  }
}

/// Turns a description, which has no capital and no full stop, into a sentence.
std::string sentence(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text.ends_with('.') ? text : text + ".";
}

}  // namespace

std::string manual_page(const CommandFacts& program) {
  // No date, so that the same sources give the same page.
  std::string out = fmt::format(".\\\" Made by {} --man.\n.TH {} 1 \"\" \"{}\" \"User Commands\"\n", program.full_name,
                                upper(program.name), program.version);
  out += fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n", roff(program.name), roff(program.description));
  if (program.commands.empty()) {
    out += fmt::format(".B {}\n{}\n", roff(program.name), roff(synopsis_of(program)));
  } else {
    for (const CommandFacts& command : program.commands)
      out += fmt::format("{}.B {}\n{}\n", &command == &program.commands.front() ? "" : ".br\n", roff(command.full_name),
                         roff(synopsis_of(command)));
  }
  out += ".SH OPTIONS\n";
  if (!program.commands.empty()) out += "Options of all commands are listed with each of them.\n";
  add_options(out, program, false);
  if (!program.commands.empty()) out += ".SH COMMANDS\n";
  for (const CommandFacts& command : program.commands) {
    out += fmt::format(".SS {} {}\n{}\n", roff(command.full_name), roff(synopsis_of(command)),
                       roff(sentence(command.description)));
    add_options(out, command, true);
    add_paragraphs(out, command.footer);
  }
  if (!program.footer.empty()) {
    out += ".SH NOTES\n";
    add_paragraphs(out, program.footer);
  }
  return out;
}

}  // namespace etendue
