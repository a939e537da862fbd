#include "core/command_line.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/log.h"
#include "core/terminal.h"
#include "core/text.h"

namespace etendue {
namespace {

/// A usage error in our own words.
struct Problem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Something that the command line asks to be printed instead of running a command.
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

/// What is wrong with a text that is to become a T; see Check::complaint.
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

/// "-o,--output" to its parts; a positional argument has none that begins with a dash.
std::vector<std::string> split_names(const std::string& names) {
  const std::vector<std::string_view> parts = text::split(names, ',');
  return {parts.begin(), parts.end()};
}

/// The name that messages use: the first long one.
std::string name_of(const OptionFacts& facts) {
  for (const std::string& name : facts.names) {
    if (name.starts_with("--")) return name;
  }
  return facts.names.empty() ? facts.value : facts.names.front();
}

bool looks_like_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && word != "--";
}

/// Those that a person may have meant.
std::vector<std::string> visible_names(const CommandFacts& facts) {
  std::vector<std::string> out;
  for (const OptionFacts& option : facts.options) {
    if (!option.hidden) out.insert(out.end(), option.names.begin(), option.names.end());
  }
  return out;
}

std::string unknown_option(const CommandFacts& facts, const std::string& word) {
  const std::string name = word.substr(0, word.find('='));
  // Between short names everything is a slip of the pen, so only long ones are guessed.
  const std::string guess = name.starts_with("--") ? text::did_you_mean(name, visible_names(facts)) : "";
  return fmt::format("'{}' has no option '{}'{}", facts.full_name, name, guess);
}

std::string lacks_value(const OptionFacts& option) {
  return fmt::format("'{} {}' lacks its value", name_of(option), option.value);
}

bool asks_for_help(const std::string& word) {
  return word == "-h" || word == "--help";
}

}  // namespace

/// A command line, word by word.
class Command::Words {
 public:
  Words(char** begin, char** end) : all_(begin, end) {}
  bool is_empty() const { return at_ == all_.size(); }
  const std::string& next() const { return all_[at_]; }
  const std::string& take() { return all_[at_++]; }
  /// The word before the next one.
  std::string previous() const { return at_ == 0 ? "" : all_[at_ - 1]; }
  /// The value of an option without one of its own: whatever comes next.
  const std::string& value_of(const OptionFacts& option) {
    if (is_empty()) throw Problem(lacks_value(option));
    return take();
  }
  bool any_left(bool (*is_wanted)(const std::string&)) const {
    const auto end = std::find(all_.begin(), all_.end(), "--");
    return std::any_of(all_.begin(), end, is_wanted);
  }

 private:
  std::vector<std::string> all_;
  std::size_t at_ = 0;
};

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

CommandOption::CommandOption(OptionFacts facts, std::function<void(const std::string&)> take,
                             std::function<std::string()> show_value)
    : facts_(std::move(facts)), take_(std::move(take)), show_value_(std::move(show_value)) {}

CommandOption* CommandOption::required() {
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
  checks_.push_back(check.complaint);
  if (!check.words.empty()) facts_.words = check.words;
  return this;
}

CommandOption* CommandOption::delimiter(char character) {
  delimiter_ = character;
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

void CommandOption::take(const std::string& value) {
  if (was_given_ && !facts_.repeatable && !facts_.value.empty())
    throw Problem(fmt::format("'{}' may be given once", name_of(facts_)));
  was_given_ = true;
  if (delimiter_ == '\0') return take_one(value);
  for (const std::string_view part : text::split(value, delimiter_)) take_one(std::string(part));
}

void CommandOption::take_one(const std::string& value) {
  for (const auto& complaint : checks_) {
    const std::string wrong = complaint(value);
    if (wrong.empty()) continue;
    throw Problem(facts_.is_positional() ? fmt::format("'{}' {}", value, wrong)
                                         : fmt::format("'{} {}' {}", name_of(facts_), value, wrong));
  }
  take_(value);
}

Command::Command(const std::string& description, const std::string& name)
    : description_(description), name_(name), full_name_(name) {}

// An option that is answered as soon as it is met.
void Command::ask(const std::string& name, const std::string& value, const std::string& description,
                  std::vector<std::string> words, std::function<std::string(const std::string&)> answer) {
  CommandOption* kept = keep(name, {.value = value, .description = description},
                             [answer](const std::string& text) { throw Asked{answer(text)}; });
  if (!words.empty()) kept->check(one_of(std::move(words)));
}

void Command::set_version_flag(const std::string& text) {
  version_ = text;
  ask("--version", "", "print the version", {}, [text](const std::string&) { return text + "\n"; });
  ask("--man", "", "print this manual as a page for man", {},
      [this](const std::string&) { return manual_page(facts()); });
  ask("--completion", "SHELL", "print a script that completes commands and options in bash, zsh or fish",
      {"bash", "zsh", "fish"}, [this](const std::string& shell) {
        return shell == "bash"  ? bash_completion(facts())
               : shell == "zsh" ? zsh_completion(facts())
                                : fish_completion(facts());
      });
}

void Command::require_subcommand() {
  needs_command_ = true;
}

void Command::footer(const std::string& text) {
  footer_ = text;
}

Command* Command::add_subcommand(const std::string& name, const std::string& description) {
  commands_.push_back(std::make_unique<Command>(description, name));
  commands_.back()->full_name_ = full_name_ + " " + name;
  return commands_.back().get();
}

void Command::callback(std::function<void()> function) {
  callback_ = std::move(function);
}

CommandOption* Command::keep(const std::string& names, OptionFacts facts, std::function<void(const std::string&)> take,
                             std::function<std::string()> show_value) {
  if (names.starts_with("-")) {
    facts.names = split_names(names);
  } else {
    facts.value = names;
  }
  options_.push_back(std::make_unique<CommandOption>(std::move(facts), std::move(take), std::move(show_value)));
  return options_.back().get();
}

CommandOption* Command::add_flag(const std::string& names, bool& variable, const std::string& description) {
  return keep(names, {.description = description}, [&variable](const std::string&) { variable = true; });
}

CommandOption* Command::add_optional_value(const std::string& name, std::string& variable, const std::string& value,
                                           const std::string& description) {
  return keep(name, {.value = value, .description = description, .value_optional = true},
              [&variable](const std::string& text) { variable = text; });
}

CommandFacts Command::facts() const {
  CommandFacts out{
      .name = name_, .full_name = full_name_, .description = description_, .footer = footer_, .version = version_};
  for (const auto& option : options_) out.options.push_back(option->facts());
  out.options.push_back({.names = {"-h", "--help"}, .description = "print this help"});
  for (const auto& command : commands_) out.commands.push_back(command->facts());
  return out;
}

CommandOption* Command::find(const std::string& name) const {
  for (const auto& option : options_) {
    if (std::ranges::find(option->facts().names, name) != option->facts().names.end()) return option.get();
  }
  return nullptr;
}

// What is required and was not given; "" when nothing is.
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

// `--name`, `--name=value` or `--name value`.
void Command::read_long(Words& words) {
  const std::string word = words.take();
  const std::size_t equals = word.find('=');
  CommandOption* option = find(word.substr(0, equals));
  if (option == nullptr) throw Problem(unknown_option(facts(), word));
  const OptionFacts& known = option->facts();
  if (equals != std::string::npos) {
    if (known.value.empty()) throw Problem(fmt::format("'{}' takes no value", name_of(known)));
    if (equals + 1 == word.size()) throw Problem(lacks_value(known));
    return option->take(word.substr(equals + 1));
  }
  if (known.value.empty()) return option->take("");
  if (known.value_optional) return option->take("-");
  option->take(words.value_of(known));
}

// `-q`, `-o value`, `-ovalue`, `-o=value`, or several flags: `-qv`.
void Command::read_short(Words& words) {
  const std::string word = words.take();
  for (std::size_t i = 1; i < word.size(); ++i) {
    CommandOption* option = find({'-', word[i]});
    if (option == nullptr) throw Problem(unknown_option(facts(), i == 1 ? word : std::string{'-', word[i]}));
    const OptionFacts& known = option->facts();
    const std::string rest = word.substr(i + 1);
    if (known.value.empty()) {
      if (rest.starts_with('=')) throw Problem(fmt::format("'{}' takes no value", name_of(known)));
      option->take("");
      continue;
    }
    return option->take(rest.empty() ? words.value_of(known) : rest.substr(rest[0] == '=' ? 1 : 0));
  }
}

void Command::read_argument(Words& words) {
  const std::string before = words.previous(), word = words.take();
  for (const auto& option : options_) {
    const OptionFacts& known = option->facts();
    if (known.is_positional() && (known.repeatable || !option->was_given())) return option->take(word);
  }
  const CommandOption* optional = find(before);
  const bool for_it = optional != nullptr && optional->facts().value_optional;
  throw Problem(fmt::format("'{}' is one argument too many for '{}'{}", word, full_name_,
                            for_it ? fmt::format("; if it is the file to write, say {}={}", before, word) : ""));
}

Command* Command::find_command(const std::string& name) const {
  std::vector<std::string> names;
  for (const auto& command : commands_) {
    if (command->name_ == name) return command.get();
    names.push_back(command->name_);
  }
  throw Problem(fmt::format("'{}' has no command '{}'{}", full_name_, name, text::did_you_mean(name, names)));
}

// Reads the words; `chosen` becomes the command that they name.
void Command::read(Words& words, Command*& chosen) {
  bool options = true;  // until "--"
  while (!words.is_empty()) {
    const std::string& word = words.next();
    if (options && word == "--") {
      options = false;
      words.take();
    } else if (options && asks_for_help(word)) {
      throw Asked{help_text(chosen->facts())};
    } else if (options && looks_like_option(word)) {
      word[1] == '-' ? chosen->read_long(words) : chosen->read_short(words);
    } else if (!chosen->commands_.empty()) {
      chosen = chosen->find_command(words.take());
    } else {
      chosen->read_argument(words);
    }
  }
  if (chosen->needs_command_) throw Problem(fmt::format("'{}' needs a command", chosen->full_name_));
  if (const std::string missing = chosen->missing_text(); !missing.empty()) throw Problem(missing);
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
  Words words(argv + 1, argv + argc);
  Command* chosen = this;
  try {
    read(words, chosen);
  } catch (const Asked& asked) {
    return answer(asked.text);
  } catch (const Problem& problem) {
    if (words.any_left(asks_for_help)) return answer(help_text(chosen->facts()));
    const std::string text = problem.what();
    log::error(fmt::format("{}{} '{} --help' tells more.", text, text.ends_with('?') ? "" : ".", chosen->full_name_));
    return false;
  }
  if (chosen->callback_) chosen->callback_();
  return std::nullopt;
}

template <class T>
CommandOption* Command::add_option(const std::string& names, T& variable, const std::string& description) {
  using Value = typename ValueOf<T>::Type;
  constexpr bool kRepeatable = !std::is_same_v<T, Value> && !std::is_same_v<T, std::optional<Value>>;
  OptionFacts facts{.value = std::is_same_v<Value, std::string> ? "TEXT" : "NUMBER",
                    .description = description,
                    .repeatable = kRepeatable};
  const auto take = [&variable, is_first = true](const std::string& text) mutable {
    Value value;
    if constexpr (std::is_same_v<Value, std::string>) {
      value = text;
    } else {
      value = *number_of<Value>(text);
    }
    if constexpr (kRepeatable) {
      if (is_first) variable.clear();  // what it holds is the default
      is_first = false;
      variable.push_back(std::move(value));
    } else {
      variable = std::move(value);
    }
  };
  CommandOption* option = keep(names, std::move(facts), take, [&variable] { return text_of(variable); });
  if constexpr (!std::is_same_v<Value, std::string>) option->check({number_complaint<Value>, {}});
  return option;
}

// Types of variables that options can have.
template CommandOption* Command::add_option(const std::string&, std::string&, const std::string&);
template CommandOption* Command::add_option(const std::string&, int&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::uint32_t&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::uint64_t&, const std::string&);
template CommandOption* Command::add_option(const std::string&, double&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::vector<std::uint32_t>&, const std::string&);
template CommandOption* Command::add_option(const std::string&, std::optional<std::uint64_t>&, const std::string&);

}  // namespace etendue
