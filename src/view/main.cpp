/// `etendue-view`, which `etendue view` starts.

#include "cli/program.h"
#include "view/view_command.h"

int main(int argc, char** argv) {
  return etendue::cli::run_program("show a scene in a web browser while it renders, and steer it", "etendue view",
                                   etendue::view::add_options, argc, argv);
}
