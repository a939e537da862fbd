#include <filesystem>

#include <fmt/format.h>

#include "cli/command.h"
#include "cli/outputs.h"
#include "cli/result_files.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/log.h"
#include "formats/mitsuba/mitsuba_writer.h"
#include "formats/nori/nori_writer.h"

namespace etendue::cli {
namespace {

struct ConvertArguments {
  std::string input, output, named_output;
  std::string dialect = "etendue";
  SceneOptions scene;
  SampleOptions sampling;
  bool force = false;
  ResultOptions results;
};

void check_output(const ConvertArguments& options) {
  namespace fs = std::filesystem;
  if (!options.output.ends_with(".xml"))
    throw Error(ErrorKind::usage, fmt::format("'{}' does not end in .xml; scenes are written as XML.", options.output));
  std::vector<NamedFile> named = {{"IN", options.input}, {"OUT", options.output}};
  for (const NamedFile& report : options.results.named_files()) named.push_back(report);
  check_distinct(named);
  std::error_code unknown;
  if (!options.force && fs::exists(options.output, unknown))
    throw Error(ErrorKind::file, fmt::format("{}: exists already; --force replaces it", options.output));
  check_writable(options.output);
}

Ending convert(const ConvertArguments& options) {
  options.results.begin();
  check_output(options);
  Scene scene = read_scene(options.input, options.scene.read_options());
  options.sampling.set_size_and_spp(scene);
  const ExistingFiles existing = options.force ? ExistingFiles::replace : ExistingFiles::refuse;
  std::vector<std::string> differences;
  if (options.dialect == "mitsuba") {
    differences = write_mitsuba_scene(options.output, scene, existing);
  } else {
    write_scene(options.output, scene, existing);
  }
  for (const std::string& sentence : differences) log::warning(sentence);
  OutputWriter files;
  options.results.write_json(files, [&] { return Json({{"output", options.output}, {"differences", differences}}); });
  if (options.results.wants_text()) log::info(fmt::format("Wrote {}.", options.output));
  files.finish();
  return Ending::ok;
}

}  // namespace

void add_convert_command(Command& app, Action& action) {
  auto* command = app.add_subcommand(
      "convert", "write a scene of any format as an XML file, with its meshes and pictures in a folder next to it");
  const auto options = std::make_shared<ConvertArguments>();
  command->add_option("IN", options->input, "scene file")->required()->file(kSceneEndings);
  command->add_option("OUT", options->output, "the new scene file; meshes and pictures go into NAME-files")
      ->file({".xml"});
  command->add_option("-o,--output,--out", options->named_output, "the same as OUT")->file({".xml"});
  command->add_option("--to", options->dialect, "XML dialect: etendue, which renders to the same film, or mitsuba")
      ->type_name("DIALECT")
      ->check(one_of({"etendue", "mitsuba"}))
      ->capture_default_str();
  options->sampling.add_size_and_spp(*command);
  options->scene.add_to(*command);
  command->add_flag("--force", options->force, "replace an existing file");
  options->results.add_to(*command);
  command->callback([&action, options] {
    if (options->output.empty() == options->named_output.empty())
      throw Error(ErrorKind::usage,
                  "Name the file to write once: etendue convert IN OUT, or etendue convert IN -o OUT.");
    if (options->output.empty()) options->output = options->named_output;
    action = [options] { return convert(*options); };
  });
}

}  // namespace etendue::cli
