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

/// A condition on the value of an option.
struct Check {
  /// Says what is wrong with the value, continuing "'--spp 0' …": "is out of range; write 1 to 64". Empty if nothing
  /// is.
  std::function<std::string(const std::string&)> complaint;
  std::vector<std::string> words;  ///< the allowed values, if these are words
};

/// A number from low to high, inclusive. T is int, unsigned, unsigned long or double.
template <class T>
Check in_range(T low, T high);
/// A number above 0.
Check positive();
/// One of these words.
Check one_of(std::vector<std::string> words);

/// One option or positional argument. All functions return `this`, so that calls can be chained.
class CommandOption {
 public:
  CommandOption(CLI::Option* option, OptionFacts facts, std::function<std::string()> show_value);

  CommandOption* required();
  /// Sets the placeholder of the value in --help: "FILE", "WxH".
  CommandOption* type_name(const std::string& name);
  /// Shows the present value of the variable as the default in --help.
  CommandOption* capture_default_str();
  CommandOption* check(const Check& check);
  /// Allows several values after one mention of an option that takes a list.
  CommandOption* allow_extra_args(bool allow);
  /// Splits a value into several: "1,2".
  CommandOption* delimiter(char character);
  /// Sets the heading under which --help lists it; "" hides it.
  CommandOption* group(const std::string& name);
  /// Declares that the value names a file, with one of these endings (".exr") if any are given; for shell completion.
  CommandOption* file(std::vector<std::string> endings = {});
  /// Declares that the value names a folder.
  CommandOption* folder();
  /// Some of its possible values; others are allowed.
  CommandOption* suggest(std::vector<std::string> words);

  const OptionFacts& facts() const { return facts_; }
  /// Whether the command line contained it.
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
  /// Requires exactly one command.
  void require_subcommand();
  /// Text at the end of --help.
  void footer(const std::string& text);
  /// Adds a command; the reference is valid as long as this object.
  Command* add_subcommand(const std::string& name, const std::string& description);
  /// Sets the function that parse calls if the command was named, after reading its options.
  void callback(std::function<void()> function);

  /// Names: "-o,--output", or "SCENE" for a positional argument. The variable must outlive parse. T must be one of the
  /// types listed at the end of command_line.cpp.
  template <class T>
  CommandOption* add_option(const std::string& names, T& variable, const std::string& description = "");
  CommandOption* add_flag(const std::string& names, bool& variable, const std::string& description = "");
  /// An option whose value is optional and follows a "=": `--json` sets the variable to "-", `--json=FILE` to FILE.
  CommandOption* add_optional_value(const std::string& name, std::string& variable, const std::string& value,
                                    const std::string& description);

  /// The table of all options, and of all commands.
  CommandFacts facts() const;

  /// Reads the arguments and calls the callbacks. Returns nothing if the program should continue. Otherwise it must
  /// end: true after --help, --version and the like, false after a usage error, which has been logged. `print` receives
  /// the text for stdout; without it, the text is printed here, and failures to write go unnoticed.
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
