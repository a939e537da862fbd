#include "core/command_line.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "core/log.h"
#include "core/terminal.h"
#include "core/text.h"

namespace etendue {
namespace {

/// A usage error with a message of this project instead of the library's.
struct Problem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Thrown if the command line asks for something to be printed instead of running a command.
struct Asked {
  std::string text;
};

template <class T>
struct ValueOf {
  using Type = T;
};
template <class T>
struct ValueOf<std::vector<T>> {
  using Type = T;
};
template <class T>
struct ValueOf<std::optional<T>> {
  using Type = T;
};

template <class T>
std::optional<T> number_of(const std::string& text) {
  T value{};
  const bool plus = std::is_floating_point_v<T> && text.size() > 1 && text[0] == '+' && text[1] != '-';
  const auto [stop, error] = std::from_chars(text.data() + (plus ? 1 : 0), text.data() + text.size(), value);
  if (error != std::errc{} || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

/// What is wrong with a text to be converted to T; see Check::complaint.
template <class T>
std::string number_complaint(const std::string& text) {
  if constexpr (std::is_same_v<T, std::string>) {
    return "";
  } else if constexpr (std::is_floating_point_v<T>) {
    return number_of<T>(text) ? "" : "is not a number";
  } else {
    if (number_of<T>(text)) return "";
    const bool digits = !text.empty() && text.find_first_not_of("0123456789", text[0] == '-') == std::string::npos;
    if (!digits || text == "-") return "is not a whole number";
    return fmt::format("is out of range; write {} to {}", std::numeric_limits<T>::min(), std::numeric_limits<T>::max());
  }
}

template <class T>
std::string text_of(const T& value) {
  if constexpr (std::is_same_v<T, std::string>) {
    return value;
  } else if constexpr (std::is_arithmetic_v<T>) {
    return fmt::format("{}", value);
  } else {
    return "";
  }
}

/// Splits "-o,--output" into names; for a positional argument, none begins with a dash.
std::vector<std::string> split_names(const std::string& names) {
  const std::vector<std::string_view> parts = text::split(names, ',');
  return {parts.begin(), parts.end()};
}

/// The name used in messages: the first long one.
std::string name_of(const OptionFacts& facts) {
  for (const std::string& name : facts.names) {
    if (name.starts_with("--")) return name;
  }
  return facts.names.empty() ? facts.value : facts.names.front();
}

bool looks_like_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && word != "--";
}

/// The names that the user may have meant.
std::vector<std::string> visible_names(const CommandFacts& facts) {
  std::vector<std::string> out;
  for (const OptionFacts& option : facts.options) {
    if (!option.hidden) out.insert(out.end(), option.names.begin(), option.names.end());
  }
  return out;
}

std::string unknown_option(const CommandFacts& facts, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  // Any two short names are one typo apart, so only long names are suggested.
  const std::string guess = name.starts_with("--") ? text::did_you_mean(name, visible_names(facts)) : "";
  return fmt::format("'{}' has no option '{}'{}", facts.full_name, name, guess);
}

/// The message for an option without its value or with too many, or for a flag with a value; "" for other errors.
std::string value_complaint(const CommandFacts& known, const CLI::ParseError& error) {
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) == nullptr &&
      dynamic_cast<const CLI::ConversionError*>(&error) == nullptr)
    return "";
  const std::string text = error.what();  // "--spp: …", or "… --spp …" for flags
  for (const OptionFacts& option : known.options) {
    const std::string name = name_of(option);
    if (option.value.empty() ? text.find(name) == std::string::npos : !text.starts_with(name + ":")) continue;
    if (option.value.empty()) return fmt::format("'{}' takes no value", name);
    if (text.find("missing") != std::string::npos) return fmt::format("'{} {}' lacks its value", name, option.value);
    return fmt::format("'{}' may be given only once", name);
  }
  return "";
}

/// `words`, with the value "-" inserted for options such as --json that stand alone.
void fill_optional_values(const CommandFacts& program, std::vector<std::string>& words) {
  std::vector<std::string> names;
  const auto collect = [&](const CommandFacts& facts) {
    for (const OptionFacts& option : facts.options) {
      if (option.value_optional) names.insert(names.end(), option.names.begin(), option.names.end());
    }
  };
  collect(program);
  for (const CommandFacts& command : program.commands) collect(command);
  for (std::string& word : words) {
    if (word == "--") return;
    if (std::ranges::find(names, word) != names.end()) word += "=-";
  }
}

}  // namespace

template <class T>
Check in_range(T low, T high) {
  return {.complaint = [low, high](const std::string& text) -> std::string {
            const std::optional<T> value = number_of<T>(text);
            if (value && *value >= low && *value <= high) return "";
            return fmt::format("is out of range; write {} to {}", low, high);
          },
          .words = {}};
}

template Check in_range(int, int);
template Check in_range(unsigned, unsigned);
template Check in_range(unsigned long, unsigned long);
template Check in_range(double, double);

Check positive() {
  return {.complaint = [](const std::string& text) -> std::string {
            const std::optional<double> value = number_of<double>(text);
            return value && *value > 0.0 ? "" : "is not above 0";
          },
          .words = {}};
}

Check one_of(std::vector<std::string> words) {
  return {.complaint = [words](const std::string& text) -> std::string {
            if (std::ranges::find(words, text) != words.end()) return "";
            return fmt::format("is none of {}{}", fmt::join(words, ", "), text::did_you_mean(text, words));
          },
          .words = words};
}

CommandOption::CommandOption(CLI::Option* option, OptionFacts facts, std::function<std::string()> show_value)
    : option_(option), facts_(std::move(facts)), show_value_(std::move(show_value)) {}

CommandOption* CommandOption::required() {
  option_->required();
  facts_.required = true;
  return this;
}

CommandOption* CommandOption::type_name(const std::string& name) {
  facts_.value = name;
  return this;
}

CommandOption* CommandOption::capture_default_str() {
  facts_.default_text = show_value_();
  return this;
}

CommandOption* CommandOption::check(const Check& check) {
  const std::string name = name_of(facts_);
  const bool positional = facts_.is_positional();
  option_->check(
      [complaint = check.complaint, name, positional](const std::string& text) -> std::string {
        const std::string wrong = complaint(text);
        if (wrong.empty()) return "";
        throw Problem(positional ? fmt::format("'{}' {}", text, wrong) : fmt::format("'{} {}' {}", name, text, wrong));
      },
      "", "");
  if (!check.words.empty()) facts_.words = check.words;
  return this;
}

CommandOption* CommandOption::allow_extra_args(bool allow) {
  option_->allow_extra_args(allow);
  return this;
}

CommandOption* CommandOption::delimiter(char character) {
  option_->delimiter(character);
  return this;
}

CommandOption* CommandOption::group(const std::string& name) {
  facts_.section = name;
  facts_.hidden = name.empty();
  return this;
}

CommandOption* CommandOption::file(std::vector<std::string> endings) {
  facts_.takes_file = true;
  facts_.endings = std::move(endings);
  if (facts_.value == "TEXT") facts_.value = "FILE";
  return this;
}

CommandOption* CommandOption::folder() {
  facts_.takes_folder = true;
  if (facts_.value == "TEXT") facts_.value = "FOLDER";
  return this;
}

CommandOption* CommandOption::suggest(std::vector<std::string> words) {
  facts_.words = std::move(words);
  return this;
}

bool CommandOption::was_given() const {
  return option_->count() > 0;
}

Command::Command(const std::string& description, const std::string& name)
    : root_(std::make_unique<CLI::App>(description, name)), app_(root_.get()), full_name_(name) {
  app_->set_help_flag("-h,--help", "");
}

Command::Command(CLI::App* app, const std::string& full_name) : app_(app), full_name_(full_name) {
  app_->set_help_flag("-h,--help", "");
}

Command::~Command() = default;

// An option that takes effect before anything else is checked.
void Command::ask(const std::string& name, const std::string& value, const std::string& description,
                  std::vector<std::string> words, std::function<std::string(const std::string&)> answer) {
  CLI::Option* option = nullptr;
  if (value.empty()) {
    option = app_->add_flag_function(name, [answer](std::int64_t) { throw Asked{answer("")}; });
  } else {
    option =
        app_->add_option_function<std::string>(name, [answer](const std::string& text) { throw Asked{answer(text)}; });
  }
  CommandOption* kept = keep(option, name, {.value = value, .description = description}, {});
  if (!words.empty()) kept->check(one_of(std::move(words)));
}

void Command::set_version_flag(const std::string& text) {
  version_ = text;
  ask("--version", "", "print the version", {}, [text](const std::string&) { return text + "\n"; });
  ask("--man", "", "print the manual page for man", {}, [this](const std::string&) { return manual_page(facts()); });
  ask("--completion", "SHELL", "print a script that completes commands and options in bash, zsh or fish",
      {"bash", "zsh", "fish"}, [this](const std::string& shell) {
        return shell == "bash"  ? bash_completion(facts())
               : shell == "zsh" ? zsh_completion(facts())
                                : fish_completion(facts());
      });
}

void Command::require_subcommand() {
  app_->require_subcommand(1);
}

void Command::footer(const std::string& text) {
  footer_ = text;
}

Command* Command::add_subcommand(const std::string& name, const std::string& description) {
  CLI::App* app = app_->add_subcommand(name, description);
  commands_.push_back(std::unique_ptr<Command>(new Command(app, full_name_ + " " + name)));
  return commands_.back().get();
}

void Command::callback(std::function<void()> function) {
  app_->callback(std::move(function));
}

CommandOption* Command::keep(CLI::Option* option, const std::string& names, OptionFacts facts,
                             std::function<std::string()> show_value) {
  if (names.starts_with("-")) {
    facts.names = split_names(names);
  } else {
    facts.value = names;
  }
  options_.push_back(std::make_unique<CommandOption>(option, std::move(facts), std::move(show_value)));
  return options_.back().get();
}

CommandOption* Command::add_flag(const std::string& names, bool& variable, const std::string& description) {
  return keep(app_->add_flag(names, variable), names, {.description = description}, {});
}

CommandOption* Command::add_optional_value(const std::string& name, std::string& variable, const std::string& value,
                                           const std::string& description) {
  return keep(app_->add_option(name, variable), name,
              {.value = value, .description = description, .value_optional = true}, {});
}

CommandFacts Command::facts() const {
  CommandFacts out{.name = app_->get_name(),
                   .full_name = full_name_,
                   .description = app_->get_description(),
                   .footer = footer_,
                   .version = version_};
  for (const auto& option : options_) out.options.push_back(option->facts());
  out.options.push_back({.names = {"-h", "--help"}, .description = "print this help"});
  for (const auto& command : commands_) out.commands.push_back(command->facts());
  return out;
}

const Command& Command::chosen() const {
  for (const auto& command : commands_) {
    if (app_->got_subcommand(command->app_)) return command->chosen();
  }
  return *this;
}

// The message about a required argument that is missing; "" if none is.
std::string Command::missing_text() const {
  for (const auto& option : options_) {
    const OptionFacts& facts = option->facts();
    if (!facts.required || option->was_given()) continue;
    if (facts.is_positional())
      return fmt::format("'{}' needs {}: {}", full_name_, heading_of(facts), facts.description);
    return fmt::format("'{}' needs the option '{} {}'", full_name_, name_of(facts), facts.value);
  }
  return "";
}

std::string Command::complaint(const CLI::ParseError& error, const std::vector<std::string>& words) const {
  const CommandFacts known = facts();
  if (const std::string text = value_complaint(known, error); !text.empty()) return text;
  const std::vector<std::string> left = app_->remaining();
  if (const auto option = std::ranges::find_if(left, looks_like_option); option != left.end())
    return unknown_option(known, *option);
  if (!commands_.empty()) {
    std::vector<std::string> names;
    for (const CommandFacts& command : known.commands) names.push_back(command.name);
    if (left.empty()) return fmt::format("'{}' needs a command", full_name_);
    return fmt::format("'{}' has no command '{}'{}", full_name_, left.front(), text::did_you_mean(left.front(), names));
  }
  if (const std::string missing = missing_text(); !missing.empty()) return missing;
  if (!left.empty()) {
    const auto at = std::ranges::find(words, left.front());
    const bool after_optional = at != words.end() && at != words.begin() && std::prev(at)->ends_with("=-");
    const std::string option = after_optional ? std::prev(at)->substr(0, std::prev(at)->size() - 1) : "";
    return fmt::format(
        "'{}' is one argument too many for '{}'{}", left.front(), full_name_,
        after_optional ? fmt::format("; if it is the file to write, say {}{}", option, left.front()) : "");
  }
  return error.what();
}

std::optional<bool> Command::parse(int argc, char** argv, const std::function<void(std::string_view)>& print) {
  const auto answer = [&](const std::string& text) {
    if (print) {
      print(text);
    } else {
      terminal::print(text);
    }
    return true;
  };
  const auto refuse = [&](const std::string& text) {
    log::error(fmt::format("{}{} '{} --help' tells more.", text, text.ends_with('?') ? "" : ".", chosen().full_name_));
    return false;
  };
  std::vector<std::string> words(argv + 1, argv + argc);
  fill_optional_values(facts(), words);
  try {
    app_->parse(std::vector<std::string>(words.rbegin(), words.rend()));
    return std::nullopt;
  } catch (const Asked& asked) {
    return answer(asked.text);
  } catch (const CLI::CallForHelp&) {
    return answer(help_text(chosen().facts()));
  } catch (const Problem& problem) {
    return refuse(problem.what());
  } catch (const CLI::ParseError& error) {
    return refuse(chosen().complaint(error, words));
  }
}

template <class T>
CommandOption* Command::add_option(const std::string& names, T& variable, const std::string& description) {
  using Value = typename ValueOf<T>::Type;
  OptionFacts facts{.value = std::is_same_v<Value, std::string> ? "TEXT" : "NUMBER",
                    .description = description,
                    .repeatable = !std::is_same_v<T, Value> && !std::is_same_v<T, std::optional<Value>>};
  CommandOption* option =
      keep(app_->add_option(names, variable), names, std::move(facts), [&variable] { return text_of(variable); });
  if constexpr (!std::is_same_v<Value, std::string>) option->check({number_complaint<Value>, {}});
  return option;
}

// The types of variables that options support.
template CommandOption* Command::add_option(const std::string&, std::string&, const std::string&);
template CommandOption* Command::add_option(const std::string&, int&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::uint32_t&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template CommandOption* Command::add_option(const std::string&, double&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::vector<std::uint32_t>&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::optional<std::uint64_t>&, const std::string&);

}  // namespace etendue
