#include <filesystem>

#include <fmt/format.h>

#include "cli/command.h"
#include "cli/outputs.h"
#include "core/errors.h"
#include "core/log.h"
#include "formats/mitsuba/mitsuba_writer.h"
#include "formats/nori/nori_writer.h"

namespace etendue::cli {
namespace {

struct Options {
  std::string input, output;
  std::string dialect = "etendue";
  SceneOptions scene;
  bool force = false;
  bool quiet = false;
};

void check_output(const Options& options) {
  namespace fs = std::filesystem;
  if (!options.output.ends_with(".xml"))
    throw Error(ErrorKind::usage, fmt::format("'{}' does not end in .xml; scenes are written as XML.", options.output));
  check_distinct({{"IN", options.input}, {"OUT", options.output}});
  std::error_code unknown;
  if (!options.force && fs::exists(options.output, unknown))
    throw Error(ErrorKind::file, fmt::format("{}: exists already; --force replaces it", options.output));
  check_writable(options.output);
}

Ending convert(const Options& options) {
  check_output(options);
  const Scene scene = read_scene(options.input, options.scene.read_options());
  const ExistingFiles existing = options.force ? ExistingFiles::replace : ExistingFiles::refuse;
  std::vector<std::string> differences;
  if (options.dialect == "mitsuba") {
    differences = write_mitsuba_scene(options.output, scene, existing);
  } else {
    write_scene(options.output, scene, existing);
  }
  for (const std::string& sentence : differences) log::warning(sentence);
  if (!options.quiet) log::info(fmt::format("Wrote {}.", options.output));
  return Ending::ok;
}

}  // namespace

void add_convert_command(Command& app, Action& action) {
  auto* command = app.add_subcommand(
      "convert", "write a scene, of whatever format, as an XML file with its meshes and pictures beside it");
  const auto options = std::make_shared<Options>();
  command->add_option("IN", options->input, "scene file")->required();
  command->add_option("OUT", options->output, "name of the new scene file; the others go into NAME-files")->required();
  command->add_option("--to", options->dialect, "whose XML: 'etendue', which renders to the same film, or 'mitsuba'")
      ->capture_default_str();
  options->scene.add_to(*command);
  command->add_flag("--force", options->force, "replace an existing file");
  command->add_flag("-q,--quiet", options->quiet, "no messages but warnings and errors");
  command->callback([&action, options] {
    if (options->dialect != "etendue" && options->dialect != "mitsuba")
      throw Error(ErrorKind::usage,
                  fmt::format("--to {}: there is no such dialect; use etendue or mitsuba.", options->dialect));
    action = [options] { return convert(*options); };
  });
}

}  // namespace etendue::cli
