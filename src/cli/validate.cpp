#include "validate/validate.h"
#include "reference/reference_renderer.h"

#include <algorithm>
#include <cstdio>
#include <memory>

#include <fmt/core.h>

#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "image/aov.h"
#include "scene/view.h"
#include "validate/html_report.h"
#include "validate/statistics.h"

namespace etendue::cli {
namespace {

struct ValidateArguments {
  std::string file;
  SceneOptions scene;
  DeviceOption device;
  ValidateOptions validate;
  std::string require = "statistical";
  bool no_flip = false;
  SampleOptions sampling;
  std::string aovs;
  ResultOptions results;
};

// A single device gets a detailed report, several devices a table.
std::string text_of(const DevicesValidation& all) {
  return all.pairs.size() == 1 ? validation_text(all.pairs.front()) : devices_text(all);
}
Json json_of(const DevicesValidation& all) {
  return all.pairs.size() == 1 ? validation_json(all.pairs.front()) : devices_json(all);
}

// The picture alone as it always was; with what is rendered beside it, a list.
Json json_of(const std::vector<DevicesValidation>& all, bool passed) {
  if (all.size() == 1) return json_of(all.front());
  Json list = Json::array();
  for (const DevicesValidation& one : all) list.push_back(json_of(one));
  return {{"validations", list}, {"passed", passed}};
}

Ending finish(const ValidateArguments& options, const std::vector<DevicesValidation>& all) {
  const bool passed = std::ranges::all_of(all, &DevicesValidation::passed);
  if (options.results.wants_text()) {
    for (const DevicesValidation& one : all) print_text((&one == all.data() ? "" : "\n") + text_of(one));
  }
  OutputWriter files;
  options.results.write_json(files, [&] { return json_of(all, passed); });
  write_text(files, options.results.junit, [&] {
    std::vector<JunitCase> cases;
    for (const DevicesValidation& one : all) {
      for (const Validation& pair : one.pairs) cases.push_back(validation_junit(pair));
    }
    return junit_xml("validate", cases);
  });
  write_text(files, options.results.html, [&] {
    MetricOptions metrics;
    metrics.flip = !options.no_flip;
    return validation_html(all.front().pairs.front(), metrics);
  });
  files.finish();
  return passed ? Ending::ok : Ending::failed;
}

// The scene with this AOV instead of the picture, under a name that says so.
Scene scene_of_aov(const Scene& scene, Aov aov, const std::string& list) {
  const std::string complaint = aov_complaint(scene.integrator, aov);
  if (!complaint.empty()) throw Error(ErrorKind::usage, fmt::format("'--aov {}': {}.", list, complaint));
  Scene beside = scene;
  beside.integrator = aov_view(view_of(scene), aov).integrator;
  beside.file = fmt::format("{}, {}", scene.file, traits(aov).name);
  return beside;
}

Ending run_validate(const ValidateArguments& options) {
  options.results.begin();
  SceneFile read = read_scene_file(options.file, options.scene.read_options());
  auto* scene = std::get_if<Scene>(&read);
  if (scene == nullptr) {
    throw Error(ErrorKind::scene, fmt::format("{}: is a test, not a scene; use 'etendue ttest'.", options.file));
  }
  options.sampling.set_size(*scene);
  DeviceOption reference = options.device;
  reference.selector = "reference";
  reference.traversal = "auto";
  ValidateOptions validate = options.validate;
  validate.seed = options.sampling.seed;
  validate.samples_per_pixel = options.sampling.spp;
  validate.worst_accepted = options.require == "identical"  ? Verdict::identical
                            : options.require == "rounding" ? Verdict::rounding_only
                                                            : Verdict::statistically_equal;
  validate.make_shaken = [](const SharedScene& shared, const RenderSettings& settings) {
    return make_shaken_reference_renderer(shared.scene(), settings);
  };
  const std::vector<LabelledFactory> devices = options.device.compared();
  if (devices.size() > 1 && !options.results.html.empty()) {
    throw Error(ErrorKind::usage,
                fmt::format("'--html {}' shows one device next to the reference, and '--device {}' names {}; name one.",
                            options.results.html, options.device.selector, devices.size()));
  }
  std::vector<Scene> scenes = {*scene};
  for (const Aov aov : parse_aovs(options.aovs)) scenes.push_back(scene_of_aov(*scene, aov, options.aovs));
  if (scenes.size() > 1 && !options.results.html.empty())
    throw Error(ErrorKind::usage, fmt::format("'--html {}' shows the picture alone; leave out '--aov {}'.",
                                              options.results.html, options.aovs));
  if (scenes.size() > 1) validate.significance = sidak_level(validate.significance, scenes.size());
  std::vector<DevicesValidation> all;
  for (const Scene& one : scenes) all.push_back(validate_devices(one, devices, reference.factory(), validate));
  return finish(options, all);
}

}  // namespace

void add_validate_command(Command& app, Action& action) {
  auto* command =
      app.add_subcommand("validate", "check whether a device renders the right image, and show where it does not");
  const auto options = std::make_shared<ValidateArguments>();
  command->add_option("SCENE", options->file, "scene file")->required()->file(kSceneEndings);
  options->sampling.add_to(*command);
  command->add_option("--aov", options->aovs, "also compare these AOVs: depth, normal, albedo …; separated by commas")
      ->type_name("NAMES");
  options->scene.add_to(*command);
  options->device.add_to(*command);
  command->add_option("--samples", options->validate.sample_budget, "number of samples compared one by one")
      ->check(positive())
      ->capture_default_str();
  command->add_option("--significance", options->validate.significance, "false-alarm rate of the statistical tests")
      ->check(in_range(1e-12, 0.5))
      ->capture_default_str();
  command
      ->add_option("--require", options->require, "worst verdict that exits with 0: identical, rounding or statistical")
      ->type_name("VERDICT")
      ->check(one_of({"identical", "rounding", "statistical"}))
      ->capture_default_str();
  command->add_flag("--allow-untested", options->validate.allow_untested,
                    "exit with 0 even if the pictures differ where the difference could not be tested");
  command->add_flag("--no-flip", options->no_flip, "leave FLIP out of the HTML report");
  options->results.add_to(*command);
  options->results.add_junit(*command);
  options->results.add_html(*command);
  command->footer(
      "Without --spp, the pictures with independent random numbers have as many samples per pixel as the scene asks "
      "for, but at least 16 and at most 64.");
  command->callback([&action, options] { action = [options] { return run_validate(*options); }; });
}

}  // namespace etendue::cli
