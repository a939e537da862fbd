#pragma once
/// The command line of the viewer, and its main loop.

#include "cli/command.h"

namespace etendue::view {

void add_options(Command& command, cli::Action& action);

}  // namespace etendue::view
