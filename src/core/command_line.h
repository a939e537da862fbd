#pragma once
/// Commands and options of the programs. The library that parses them takes many seconds to compile wherever it is
/// included, so only command_line.cpp includes it.

#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/command_facts.h"

namespace CLI {
class App;
class Option;
class ParseError;
}  // namespace CLI

namespace etendue {

/// What the value of an option has to fulfil.
struct Check {
  /// What is wrong with the value, continuing "'--spp 0' …": "is out of range; write 1 to 64". Empty: nothing.
  std::function<std::string(const std::string&)> complaint;
  std::vector<std::string> words;  ///< the values it allows, where these are words
};

/// From low to high, both allowed. T: int, unsigned, unsigned long or double.
template <class T>
Check in_range(T low, T high);
/// A number above 0.
Check positive();
/// One of these words.
Check one_of(std::vector<std::string> words);

/// One option or positional argument. All functions return `this`, for chains.
class CommandOption {
 public:
  CommandOption(CLI::Option* option, OptionFacts facts, std::function<std::string()> show_value);

  CommandOption* required();
  /// What --help calls the value: "FILE", "WxH".
  CommandOption* type_name(const std::string& name);
  /// Says the value that the variable has now in --help.
  CommandOption* capture_default_str();
  CommandOption* check(const Check& check);
  /// Whether several values may follow one mention of an option that takes a list.
  CommandOption* allow_extra_args(bool allow);
  /// Splits a value into several: "1,2".
  CommandOption* delimiter(char character);
  /// The heading that --help lists it under; "": nowhere.
  CommandOption* group(const std::string& name);
  /// The value names a file, one with these endings (".exr") where there are any; for completion in shells.
  CommandOption* file(std::vector<std::string> endings = {});
  /// The value names a folder.
  CommandOption* folder();
  /// Some values that it can have, beside others.
  CommandOption* suggest(std::vector<std::string> words);

  const OptionFacts& facts() const { return facts_; }
  /// Whether the command line had it.
  bool was_given() const;

 private:
  CLI::Option* option_;
  OptionFacts facts_;
  std::function<std::string()> show_value_;
};

/// A program, or a command of one.
class Command {
 public:
  /// The description is a sentence without its full stop.
  Command(const std::string& description, const std::string& name);
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  /// Makes --version print that, --man the manual page, and --completion the script for a shell.
  void set_version_flag(const std::string& text);
  /// Exactly one command has to be named.
  void require_subcommand();
  /// The end of --help.
  void footer(const std::string& text);
  /// Lives as long as this.
  Command* add_subcommand(const std::string& name, const std::string& description);
  /// Called by parse if the command was named, after its options were read.
  void callback(std::function<void()> function);

  /// Names: "-o,--output", or "SCENE" for a positional argument. The variable has to outlive parse. T is one of the
  /// types at the end of command_line.cpp, or a new line there.
  template <class T>
  CommandOption* add_option(const std::string& names, T& variable, const std::string& description = "");
  CommandOption* add_flag(const std::string& names, bool& variable, const std::string& description = "");
  /// An option whose value may be left out and stands behind a "=" where it is given: `--json` makes the variable "-",
  /// `--json=FILE` makes it FILE.
  CommandOption* add_optional_value(const std::string& name, std::string& variable, const std::string& value,
                                    const std::string& description);

  /// The table of all options, and of all commands.
  CommandFacts facts() const;

  /// Reads the arguments and calls the callbacks; nothing: go on. Else the program is to end: true after --help,
  /// --version and the like, false after a usage error, which has been told to the log.
  /// `print` takes what belongs to stdout; without it that is printed here, where nobody learns why it did not arrive.
  std::optional<bool> parse(int argc, char** argv, const std::function<void(std::string_view)>& print = {});

 private:
  Command(CLI::App* app, const std::string& full_name);
  CommandOption* keep(CLI::Option* option, const std::string& names, OptionFacts facts,
                      std::function<std::string()> show_value);
  void ask(const std::string& name, const std::string& value, const std::string& description,
           std::vector<std::string> words, std::function<std::string(const std::string&)> answer);
  const Command& chosen() const;
  std::string complaint(const CLI::ParseError& error, const std::vector<std::string>& words) const;
  std::string missing_text() const;

  std::unique_ptr<CLI::App> root_;  ///< of a program; commands belong to it
  CLI::App* app_;
  std::string full_name_;
  std::string version_, footer_;
  std::vector<std::unique_ptr<Command>> commands_;
  std::vector<std::unique_ptr<CommandOption>> options_;
};

}  // namespace etendue
