/// `etendue-view`, which `etendue view` starts.

#include "cli/program.h"
#include "view/view_command.h"

int main(int argc, char** argv) {
  return etendue::cli::run_program("show and control a render in a web browser", "etendue view",
                                   etendue::view::add_options, argc, argv);
}
