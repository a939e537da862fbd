#include "cli/command.h"
#include "cli/program.h"

namespace {

void add_commands(etendue::Command& app, etendue::cli::Action& action) {
  app.require_subcommand();
  etendue::cli::add_render_command(app, action);
  etendue::cli::add_devices_command(app, action);
  etendue::cli::add_check_command(app, action);
  etendue::cli::add_ttest_command(app, action);
  etendue::cli::add_convert_command(app, action);
  etendue::cli::add_merge_command(app, action);
  etendue::cli::add_denoise_command(app, action);
  etendue::cli::add_compare_command(app, action);
  etendue::cli::add_validate_command(app, action);
  etendue::cli::add_chi2_command(app, action);
  etendue::cli::add_selftest_command(app, action);
  etendue::cli::add_bench_command(app, action);
  etendue::cli::add_explain_command(app, action);
  etendue::cli::add_view_command(app, action);
}

}  // namespace

int main(int argc, char** argv) {
  return etendue::cli::run_program("a Vulkan path tracer that gives the same light on every device, and proves it",
                                   "etendue", add_commands, argc, argv);
}
