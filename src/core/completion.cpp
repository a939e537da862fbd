/// Scripts that complete a program's commands, options and values in bash, zsh and fish, from the table of its options.

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/command_facts.h"

namespace etendue {
namespace {

/// In single quotes, as all three shells read it; fish also interprets backslashes within them.
std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// A valid name for a shell function: "etendue_sculpt".
std::string function_name(const CommandFacts& program) {
  std::string out = program.name;
  std::ranges::replace(out, '-', '_');
  return out;
}

/// The placeholder and description of a value, without characters that are special in shells.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '[' || c == ']' || c == ':' ? ' ' : c;
  return out;
}

/// The beginning of a description, without its details.
std::string summary(const std::string& description) {
  std::size_t end = description.size();
  for (const char* pause : {": ", "; ", " ("}) end = std::min(end, description.find(pause));
  return description.substr(0, end);
}

// --- bash ---

/// A call that fills COMPREPLY with the possible values of an option or argument; empty if there are none to offer.
std::string bash_values(const OptionFacts& option, const std::string& function) {
  std::string out;
  if (!option.words.empty())
    out = fmt::format("COMPREPLY=($(compgen -W {} -- \"$cur\"))",
                      shell_word(fmt::format("{}", fmt::join(option.words, " "))));
  if (option.takes_folder) out = fmt::format("_{}_files \"$cur\" /", function);
  if (option.takes_file) out = fmt::format("_{}_files \"$cur\" {}", function, fmt::join(option.endings, " "));
  return out.empty() ? ":" : out;
}

std::string bash_command(const CommandFacts& command, const std::string& function) {
  std::string values, names, argument = ":";
  for (const OptionFacts& option : command.options) {
    if (option.hidden) continue;
    if (option.is_positional()) {
      argument = bash_values(option, function);
      continue;
    }
    names += (names.empty() ? "" : " ") + fmt::format("{}", fmt::join(option.names, " "));
    if (option.value.empty()) continue;
    // The text after "=" is a value, and so is the next word, unless the value is optional.
    std::vector<std::string> before;
    for (const std::string& name : option.names) {
      if (!option.value_optional) before.push_back(name);
      if (name.starts_with("--")) before.push_back("=" + name);
    }
    values += fmt::format("        {}) {}; return ;;\n", fmt::join(before, "|"), bash_values(option, function));
  }
  return fmt::format(
      "      case $option in\n{0}      esac\n      case $cur in\n"
      "        -*) COMPREPLY=($(compgen -W {1} -- \"$cur\")) ;;\n        *) {2} ;;\n      esac ;;\n",
      values, shell_word(names), argument);
}

// --- zsh ---

std::string zsh_values(const OptionFacts& option) {
  if (option.takes_folder) return "_files -/";
  if (option.takes_file && option.endings.empty()) return "_files";
  if (option.takes_file) {
    std::vector<std::string> endings;
    for (const std::string& ending : option.endings) endings.push_back(ending.substr(1));
    return fmt::format("_files -g \"*.({})(-.)\"", fmt::join(endings, "|"));
  }
  return option.words.empty() ? " " : fmt::format("({})", fmt::join(option.words, " "));
}

/// Specifications for _arguments, one per line.
std::string zsh_arguments(const CommandFacts& command, const std::string& indent) {
  std::string out;
  for (const OptionFacts& option : command.options) {
    if (option.hidden) continue;
    if (option.is_positional()) {
      out += fmt::format(" \\\n{}{}", indent,
                         shell_word(fmt::format("{}:{}:{}",
                                                option.repeatable ? "*"
                                                : option.required ? ""
                                                                  : ":",
                                                plain(option.value), zsh_values(option))));
      continue;
    }
    const std::string repeat = option.repeatable ? "*" : fmt::format("({})", fmt::join(option.names, " "));
    for (const std::string& name : option.names) {
      const std::string sign = option.value.empty()     ? ""
                               : option.value_optional  ? "=-"
                               : name.starts_with("--") ? "="
                                                        : "+";
      const std::string value = option.value.empty() ? ""
                                                     : fmt::format("{}{}:{}", option.value_optional ? "::" : ":",
                                                                   plain(option.value), zsh_values(option));
      out += fmt::format(
          " \\\n{}{}", indent,
          shell_word(fmt::format("{}{}{}[{}]{}", repeat, name, sign, plain(summary(option.description)), value)));
    }
  }
  return out;
}

// --- fish ---

/// Within single quotes, fish interprets \\ and \'.
std::string fish_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

std::string fish_values(const OptionFacts& option, const std::string& function) {
  if (!option.words.empty()) return " -x -a " + fish_quoted(fmt::format("{}", fmt::join(option.words, " ")));
  if (option.takes_folder) return " -x -a '(__fish_complete_directories)'";
  if (option.takes_file && option.endings.empty()) return " -r -F";
  if (option.takes_file)
    return fmt::format(" -x -a {}",
                       fish_quoted(fmt::format("(__{}_files {})", function, fmt::join(option.endings, " "))));
  return " -x";
}

std::string fish_option(const OptionFacts& option, const std::string& start, const std::string& function) {
  if (option.is_positional()) {
    if (option.words.empty() && !option.takes_file && !option.takes_folder) return "";
    return start + fish_values(option, function) + "\n";
  }
  std::string out = start;
  for (const std::string& name : option.names)
    out += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  out += " -d " + fish_quoted(summary(option.description));
  if (!option.value.empty() && !option.value_optional) out += fish_values(option, function);
  return out + "\n";
}

}  // namespace

std::string bash_completion(const CommandFacts& program) {
  const std::string function = function_name(program);
  std::string names, cases;
  for (const CommandFacts& command : program.commands) {
    names += (names.empty() ? "" : "|") + command.name;
    cases += fmt::format("    {})\n{}", command.name, bash_command(command, function));
  }
  CommandFacts top = program;
  if (!program.commands.empty()) {
    std::vector<std::string> words;
    for (const CommandFacts& command : program.commands) words.push_back(command.name);
    top.options.push_back({.value = "COMMAND", .words = words});
  }
  cases += "    *)\n" + bash_command(top, function);
  return fmt::format(R"(# Completion of {0} for bash; made by: {0} --completion bash

# Files that begin with $1 and have one of the endings $2 …, and folders; "/": folders only.
_{1}_files() {{
  local cur=$1 name ending
  shift
  compopt -o filenames 2>/dev/null
  while IFS= read -r name; do
    if [[ -d ${{name/#\~/$HOME}} ]]; then COMPREPLY+=("$name"); continue; fi
    if [[ $# -eq 0 ]]; then COMPREPLY+=("$name"); fi
    for ending in "$@"; do
      if [[ ${{name,,}} == *"$ending" ]]; then COMPREPLY+=("$name"); break; fi
    done
  done < <(compgen -f -- "$cur")
}}

_{1}() {{
  local cur=${{COMP_WORDS[COMP_CWORD]}} option=${{COMP_WORDS[COMP_CWORD - 1]}} command= word
  COMPREPLY=()
  # "--option=value" comes as three words; an option whose value is behind "=" is written "=--option" below.
  if [[ $cur == '=' && COMP_CWORD -gt 1 ]]; then
    cur= option==$option
  elif [[ $option == '=' && COMP_CWORD -gt 2 ]]; then
    option==${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case $word in
      {2}) command=$word; break ;;
    esac
  done
  case $command in
{3}  esac
}}

complete -F _{1} {0}
)",
                     program.name, function, names.empty() ? "''" : names, cases);
}

std::string zsh_completion(const CommandFacts& program) {
  const std::string function = function_name(program);
  std::string out =
      fmt::format("#compdef {0}\n# Completion of {0} for zsh; made by: {0} --completion zsh\n\n_{1}() {{\n",
                  program.name, function);
  if (program.commands.empty()) {
    out += fmt::format("  _arguments -s{}\n", zsh_arguments(program, "    "));
  } else {
    out += "  local curcontext=$curcontext state state_descr line\n  typeset -A opt_args\n";
    out += fmt::format("  _arguments -C{} \\\n    '1:command:->command' \\\n    '*::argument:->argument'\n",
                       zsh_arguments(program, "    "));
    out += "  case $state in\n    command)\n      local -a commands=(\n";
    for (const CommandFacts& command : program.commands)
      out += "        " + shell_word(command.name + ":" + plain(summary(command.description))) + "\n";
    out += "      )\n      _describe -t commands command commands ;;\n    argument)\n";
    out += fmt::format("      curcontext=\"${{curcontext%:*}}-$words[1]:\"\n      case $words[1] in\n");
    for (const CommandFacts& command : program.commands)
      out += fmt::format("        {})\n          _arguments -s{} ;;\n", command.name,
                         zsh_arguments(command, "            "));
    out += "      esac ;;\n  esac\n";
  }
  // Works in both ways of loading it: as a file in $fpath, and by source.
  out += fmt::format("}}\n\nif [[ $funcstack[1] == _{1} ]]; then\n  _{1} \"$@\"\nelse\n  compdef _{1} {0}\nfi\n",
                     program.name, function);
  return out;
}

std::string fish_completion(const CommandFacts& program) {
  const std::string function = function_name(program);
  std::string out = fmt::format(R"(# Completion of {0} for fish; made by: {0} --completion fish

# Files with one of the endings, and folders.
function __{1}_files
    set -l endings '(/|'(string join '|' (string escape --style=regex -- $argv))')$'
    for line in (complete -C '__{1}_none '(string replace -r -- '^--[^=]*=' '' (commandline -ct)))
        string match -r -- '^[^\t]*' $line | string match -r -- '.*'$endings | string match -v -r '^(/|\.[a-z]+)$'
    end
end

complete -c {0} -f
)",
                                program.name, function);
  const std::string top =
      fmt::format("complete -c {}{}", program.name, program.commands.empty() ? "" : " -n __fish_use_subcommand");
  for (const CommandFacts& command : program.commands)
    out += fmt::format("{} -a {} -d {}\n", top, command.name, fish_quoted(summary(command.description)));
  for (const OptionFacts& option : program.options) {
    if (!option.hidden) out += fish_option(option, top, function);
  }
  for (const CommandFacts& command : program.commands) {
    const std::string start =
        fmt::format("complete -c {} -n '__fish_seen_subcommand_from {}'", program.name, command.name);
    for (const OptionFacts& option : command.options) {
      if (!option.hidden) out += fish_option(option, start, function);
    }
  }
  return out;
}

}  // namespace etendue
