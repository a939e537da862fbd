#include "view/view_command.h"

#include <chrono>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "cli/results.h"
#include "cli/signals.h"
#include "cli/units.h"
#include "cli/view_options.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/log.h"
#include "view/guard.h"
#include "view/http_server.h"
#include "view/pages.h"
#include "view/preview.h"
#include "view/watch.h"

namespace etendue::view {
namespace {

Scene read(const cli::ViewOptions& options) {
  Scene scene = read_scene(options.scene_file, options.scene.read_options());
  options.sampling.set_size(scene);
  return scene;
}

/// "http://127.0.0.1:8017/token/". If the server listens on all addresses, the host is "localhost".
std::string address_of(const cli::ViewOptions& options, int port, const std::string& token) {
  const bool every = options.listen == "0.0.0.0" || options.listen == "::";
  const std::string host = every                                           ? "localhost"
                           : options.listen.find(':') != std::string::npos ? "[" + options.listen + "]"
                                                                           : options.listen;
  return fmt::format("http://{}:{}/{}/", host, port, token);
}

cli::Ending view(const cli::ViewOptions& options) {
  cli::SignalWatch signals(true);
  options.results.begin();
  // Wrong options end the command; errors in the scene are shown on the page, since the file can be corrected and read
  // again.
  if (!options.sampling.size.empty()) cli::parse_size(options.sampling.size);
  options.scene.read_options();
  const std::string token = random_token();
  const Guard guard(token, options.listen);
  Preview preview({.read_scene = [&options] { return read(options); },
                   .device = options.device.selection(),
                   .seed = options.sampling.seed,
                   .samples = options.sampling.spp});
  const HttpServer server(
      options.listen, static_cast<int>(options.port), [&](const Request& request) { return guard.admit(request); },
      [&](const Request& request) { return answer(preview, guard.place_of(request), request); });
  signals.saving_starts();
  const std::string address = address_of(options, server.port(), token);
  cli::OutputWriter files;
  options.results.write_json(files, [&] { return Json({{"address", address}, {"port", server.port()}}); });
  files.finish();
  if (options.results.wants_text()) cli::print_result("{}\n", address);
  cli::finish_results();
  log::info("Open the address above in a browser; anyone who knows it can control the viewer. Ctrl-C ends the viewer.");
  FileWatch watch;
  while (!signals.stop_asked()) {
    for (int i = 0; i < 3 && !signals.stop_asked(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (watch.changed(preview.files())) preview.reload();
  }
  preview.stop();
  log::info("The viewer has ended.");
  return cli::Ending::ok;
}

}  // namespace

void add_options(Command& command, cli::Action& action) {
  const auto options = std::make_shared<cli::ViewOptions>();
  options->add_to(command);
  action = [options] { return view(*options); };
}

}  // namespace etendue::view
