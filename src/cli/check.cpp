#include "scene/check.h"

#include <fmt/core.h>
#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "core/json.h"
#include "core/printable.h"
#include "scene/coincident.h"
#include "validate/scene_probe.h"

namespace etendue::cli {
namespace {

struct CheckArguments {
  std::vector<std::string> files;
  SceneOptions scene;
  SampleOptions sampling;
  ResultOptions results;
};

Json finding_json(const Diagnostic& finding) {
  return {{"severity", to_string(finding.severity)},
          {"file", finding.position.file},
          {"line", finding.position.line},
          {"column", finding.position.column},
          {"message", finding.message}};
}

Result check_files(const CheckArguments& options) {
  options.results.begin();
  Result result = Ending::ok;
  auto out = Json::array();
  for (const std::string& file : options.files) {
    Diagnostics diagnostics;
    ReadOptions read = options.scene.read_options();
    read.strict = true;  // a check is always strict: an unknown property is considered a mistake
    if (std::optional<SceneFile> content = read_scene_file(file, read, diagnostics)) {
      if (auto* scene = std::get_if<Scene>(&*content)) options.sampling.set_size_and_spp(*scene);
      check_scene_file(*content, diagnostics);
      check_coincident(*content, diagnostics);
      if (auto* scene = std::get_if<Scene>(&*content)) probe_scene(std::move(*scene), diagnostics);
    }
    for (const Diagnostic& d : diagnostics.list()) {
      if (d.severity == Severity::error && result == Result(Ending::ok)) result = d.kind;
      out.push_back(finding_json(d));
      if (options.results.wants_text())
        print_result("{}: {}\n", to_string(d.severity), text::printable(to_string(d), text::kLongestLine));
    }
    if (!options.results.wants_text()) continue;
    if (diagnostics.dropped() > 0) print_result("{} more findings are not listed\n", diagnostics.dropped());
    if (!diagnostics.has_errors()) print_result("{}: ok\n", text::printable(file, text::kLongestLine));
  }
  OutputWriter files;
  options.results.write_json(files, [&] { return out; });
  files.finish();
  return result;
}

}  // namespace

void add_check_command(Command& app, Action& action) {
  auto* command = app.add_subcommand(
      "check", "read scenes strictly and list everything that is wrong or probably not intended, without rendering");
  const auto options = std::make_shared<CheckArguments>();
  command->add_option("SCENE", options->files, "scene files")->required()->file(kSceneEndings);
  options->sampling.add_size_and_spp(*command);
  options->scene.add_to(*command);
  options->results.add_to(*command);
  command->callback([&action, options] { action = [options] { return check_files(*options); }; });
}

}  // namespace etendue::cli
