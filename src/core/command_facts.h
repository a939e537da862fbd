#pragma once
/// What a program knows about its commands and options: one table, from which the help, the manual page and the
/// completion of the shells are written.

#include <string>
#include <vector>

namespace etendue {

/// One option or positional argument.
struct OptionFacts {
  std::vector<std::string> names;  ///< "-o", "--output"; none: a positional argument
  std::string value;               ///< what its value is called, "FILE"; empty: a flag
  std::string description;
  std::string default_text;          ///< empty: nothing to tell
  std::vector<std::string> words;    ///< values it can have, or some of them
  std::vector<std::string> endings;  ///< of files, ".exr"; none: any
  std::string section;               ///< heading that the help lists it under; "Options" where it has none
  bool takes_file = false, takes_folder = false;
  bool required = false, repeatable = false;
  bool value_optional = false;  ///< `--json` or `--json=FILE`
  bool hidden = false;

  bool is_positional() const { return names.empty(); }
};

/// A program, or a command of one.
struct CommandFacts {
  std::string name;         ///< "render"
  std::string full_name;    ///< "etendue render"
  std::string description;  ///< a sentence without its full stop
  std::string footer;       ///< paragraphs behind the options, "\n" between them
  std::string version;      ///< of a program
  std::vector<OptionFacts> options;
  std::vector<CommandFacts> commands;
};

/// The names with commas between them and the value: "-o, --output FILE", "--json[=FILE]", "SCENE".
std::string heading_of(const OptionFacts& option);

/// What follows the program's name: "render [OPTIONS] SCENE".
std::string synopsis_of(const CommandFacts& command);

/// The sections in the order in which they come up, each with its options; hidden ones are left out. Positional
/// arguments come first, as "Arguments".
struct OptionSection {
  std::string name;
  std::vector<const OptionFacts*> options;
};
std::vector<OptionSection> sections_of(const CommandFacts& command);

/// What --help prints: lines of at most 80 characters, but for words that are longer.
std::string help_text(const CommandFacts& command);

/// A manual page for section 1, in the macros of man(7).
std::string manual_page(const CommandFacts& program);

/// Scripts that complete the program's commands, options and values. Each is to be sourced or put where the shell looks
/// for completions.
std::string bash_completion(const CommandFacts& program);
std::string zsh_completion(const CommandFacts& program);
std::string fish_completion(const CommandFacts& program);

}  // namespace etendue
