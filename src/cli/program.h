#pragma once
/// What every program of ours does around its commands.

#include <functional>
#include <string>

#include "cli/command.h"

namespace etendue::cli {

/// Gives the program its options or commands; whichever is asked for sets the action.
using CommandSetup = std::function<void(Command& app, Action& action)>;

/// For main: reads the arguments, runs the action and returns the exit code. Errors become sentences on stderr; no
/// stream that is closed, full or broken ends the program.
int run_program(const std::string& description, const std::string& name, const CommandSetup& set_up, int argc,
                char** argv);

}  // namespace etendue::cli
