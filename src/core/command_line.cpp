#include "core/command_line.h"

#include <cstdint>
#include <sstream>

#include <CLI/CLI.hpp>

namespace etendue {

template <class T>
Check in_range(T low, T high) {
  return Check(std::make_shared<CLI::Range>(low, high));
}

template Check in_range(int, int);
template Check in_range(unsigned, unsigned);
template Check in_range(unsigned long, unsigned long);
template Check in_range(double, double);

Check positive() {
  return Check(std::make_shared<CLI::Validator>(CLI::PositiveNumber));
}

Check one_of(std::vector<std::string> words) {
  return Check(std::make_shared<CLI::IsMember>(std::move(words)));
}

CommandOption* CommandOption::required() {
  option_->required();
  return this;
}

CommandOption* CommandOption::type_name(const std::string& name) {
  option_->type_name(name);
  return this;
}

CommandOption* CommandOption::capture_default_str() {
  option_->capture_default_str();
  return this;
}

CommandOption* CommandOption::check(const Check& check) {
  option_->check(check.validator());
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
  option_->group(name);
  return this;
}

Command::Command(const std::string& description, const std::string& name)
    : root_(std::make_unique<CLI::App>(description, name)), app_(root_.get()) {}

Command::Command(CLI::App* app) : app_(app) {}

Command::~Command() = default;

void Command::set_version_flag(const std::string& text) {
  app_->set_version_flag("--version", text);
}

void Command::require_subcommand() {
  app_->require_subcommand(1);
}

void Command::footer(const std::string& text) {
  app_->footer(text);
}

Command* Command::add_subcommand(const std::string& name, const std::string& description) {
  commands_.push_back(std::unique_ptr<Command>(new Command(app_->add_subcommand(name, description))));
  return commands_.back().get();
}

void Command::callback(std::function<void()> function) {
  app_->callback(std::move(function));
}

CommandOption* Command::keep(CLI::Option* option) {
  options_.push_back(std::make_unique<CommandOption>(option));
  return options_.back().get();
}

CommandOption* Command::add_flag(const std::string& names, bool& variable, const std::string& description) {
  return keep(app_->add_flag(names, variable, description));
}

std::optional<bool> Command::parse(int argc, char** argv, const std::function<void(std::string_view)>& print) {
  try {
    app_->parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    if (!print) return app_->exit(error) == 0;
    std::ostringstream out;
    const bool asked = app_->exit(error, out) == 0;
    print(out.str());
    return asked;
  }
}

template <class T>
CommandOption* Command::add_option(const std::string& names, T& variable, const std::string& description) {
  return keep(app_->add_option(names, variable, description));
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
