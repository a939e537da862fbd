#pragma once
/// The frame of every program of this project, around its commands.

#include <functional>
#include <string>

#include "cli/command.h"

namespace etendue::cli {

/// Adds the options or commands of the program; the one that is requested sets the action.
using CommandSetup = std::function<void(Command& app, Action& action)>;

/// For main: reads the arguments, runs the action and returns the exit code. Errors become sentences on stderr; closed,
/// full or broken streams do not end the program.
int run_program(const std::string& description, const std::string& name, const CommandSetup& set_up, int argc,
                char** argv);

}  // namespace etendue::cli
