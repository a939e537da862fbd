#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "cli/command.h"
#include "cli/view_options.h"
#include "core/errors.h"

namespace etendue::cli {
namespace {

/// The arguments of this process, the name of the program first.
std::vector<std::string> own_arguments() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::string> arguments;
  for (std::size_t begin = 0; begin < all.size(); begin = all.find('\0', begin) + 1)
    arguments.emplace_back(all.c_str() + begin);
  return arguments;
}

/// The viewer is a separate program next to this one, so that other commands do not contain a web server.
[[noreturn]] void become_viewer() {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  std::string viewer = (self.parent_path() / "etendue-view").string();
  if (error || access(viewer.c_str(), X_OK) != 0) {
    throw Error(
        ErrorKind::usage,
        fmt::format("{}: there is no viewer next to this program; it needs the library cpp-httplib (on Debian and "
                    "Ubuntu the package libcpp-httplib-dev) when Etendue is built. './run view' installs it and builds "
                    "the viewer, 'cmake -DETENDUE_VIEW=ON' enables it.",
                    viewer));
  }
  std::vector<std::string> arguments = own_arguments();
  std::vector<char*> words = {viewer.data()};
  for (std::size_t i = 2; i < arguments.size(); ++i) words.push_back(arguments[i].data());  // behind "etendue view"
  words.push_back(nullptr);
  execv(viewer.c_str(), words.data());
  throw Error(ErrorKind::file, fmt::format("{}: cannot be started: {}", viewer, std::strerror(errno)));
}

}  // namespace

void ViewOptions::add_to(Command& command) {
  command.add_option("SCENE", scene_file, "scene file; it is read again whenever it or a file that it names changes")
      ->required()
      ->file(kSceneEndings);
  command
      .add_option("--listen", listen,
                  "address to listen on; with any other than this machine's own, anyone who knows the address of the "
                  "page has access")
      ->type_name("ADDR")
      ->capture_default_str();
  command.add_option("--port", port, "port to listen on; 0: any free one")
      ->check(in_range(0u, 65535u))
      ->capture_default_str();
  sampling.add_to(command);
  scene.add_to(command);
  device.add_to(command);
  results.add_to(command);
  command.footer("The address of the page is printed on stdout. Ctrl-C ends the viewer with exit code 0.");
}

void add_view_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("view", "show and control a render in a web browser");
  const auto options = std::make_shared<ViewOptions>();
  options->add_to(*command);
  command->callback([&action, options] { action = []() -> Result { become_viewer(); }; });
}

}  // namespace etendue::cli
