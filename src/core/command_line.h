#pragma once
/// Commands and options of the programs. The library that parses them takes many seconds to compile wherever it is
/// included, so only command_line.cpp includes it.

#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class Validator;
}  // namespace CLI

namespace etendue {

/// What the value of an option has to fulfil; a usage error that says so otherwise.
class Check {
 public:
  explicit Check(std::shared_ptr<const CLI::Validator> validator) : validator_(std::move(validator)) {}
  const CLI::Validator& validator() const { return *validator_; }

 private:
  std::shared_ptr<const CLI::Validator> validator_;
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
  explicit CommandOption(CLI::Option* option) : option_(option) {}

  CommandOption* required();
  /// What --help calls the value: "FILE", "W×H".
  CommandOption* type_name(const std::string& name);
  /// Says the value that the variable has now in --help.
  CommandOption* capture_default_str();
  CommandOption* check(const Check& check);
  /// Whether several values may follow one mention of an option that takes a list.
  CommandOption* allow_extra_args(bool allow);
  /// Splits a value into several: "1,2".
  CommandOption* delimiter(char character);
  /// Where --help lists it; "": nowhere.
  CommandOption* group(const std::string& name);

 private:
  CLI::Option* option_;
};

/// A program, or a command of one.
class Command {
 public:
  Command(const std::string& description, const std::string& name);
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  /// Makes --version print that.
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

  /// Reads the arguments and calls the callbacks; nothing: go on. Else the program is to end: true after --help or
  /// --version, false after a usage error; what there is to say about it has been printed.
  /// `print` takes what belongs to stdout; without it that is printed here, where nobody learns why it did not arrive.
  std::optional<bool> parse(int argc, char** argv, const std::function<void(std::string_view)>& print = {});

 private:
  explicit Command(CLI::App* app);
  CommandOption* keep(CLI::Option* option);

  std::unique_ptr<CLI::App> root_;  ///< of a program; commands belong to it
  CLI::App* app_;
  std::vector<std::unique_ptr<Command>> commands_;
  std::vector<std::unique_ptr<CommandOption>> options_;
};

}  // namespace etendue
