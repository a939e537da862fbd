#pragma once
/// The table of a program's commands and options, from which its help, manual page and shell completions are written.

#include <string>
#include <vector>

namespace etendue {

/// One option or positional argument.
struct OptionFacts {
  std::vector<std::string> names;  ///< "-o", "--output"; empty for a positional argument
  std::string value;               ///< placeholder of its value, "FILE"; empty for a flag
  std::string description;
  std::string default_text;          ///< empty if it is not shown
  std::vector<std::string> words;    ///< possible values, or some of them
  std::vector<std::string> endings;  ///< file name endings, ".exr"; empty: any
  std::string section;               ///< heading under which the help lists it; "Options" by default
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
  std::string footer;       ///< paragraphs after the options, separated by "\n"
  std::string version;      ///< of a program
  std::vector<OptionFacts> options;
  std::vector<CommandFacts> commands;
};

/// The names, separated by commas, and the value: "-o, --output FILE", "--json[=FILE]", "SCENE".
std::string heading_of(const OptionFacts& option);

/// The usage line after the program's name: "render [OPTIONS] SCENE".
std::string synopsis_of(const CommandFacts& command);

/// The sections in order of appearance, each with its options; hidden ones are left out. Positional arguments come
/// first, as "Arguments".
struct OptionSection {
  std::string name;
  std::vector<const OptionFacts*> options;
};
std::vector<OptionSection> sections_of(const CommandFacts& command);

/// The text printed by --help, in lines of at most 80 characters, except for longer words.
std::string help_text(const CommandFacts& command);

/// A manual page for section 1, in the macros of man(7).
std::string manual_page(const CommandFacts& program);

/// Scripts that complete the program's commands, options and values. Source them, or install them where the shell looks
/// for completions.
std::string bash_completion(const CommandFacts& program);
std::string zsh_completion(const CommandFacts& program);
std::string fish_completion(const CommandFacts& program);

}  // namespace etendue
