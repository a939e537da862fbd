#pragma once
/// The command line of the viewer, and what runs until it is ended.

#include "cli/command.h"

namespace etendue::view {

void add_options(Command& command, cli::Action& action);

}  // namespace etendue::view
