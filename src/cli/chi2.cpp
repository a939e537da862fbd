#include "validate/chi2.h"

#include <cstdio>
#include <memory>

#include <fmt/core.h>

#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"

namespace etendue::cli {
namespace {

struct Chi2Arguments {
  std::vector<std::string> files;
  SceneOptions scene;
  DeviceOption device;
  Chi2Options test;
  ResultOptions results;
};

Ending run_files(const Chi2Arguments& options) {
  options.results.begin();
  // All files are read before the first device is touched.
  std::vector<Chi2Test> tests;
  for (const std::string& file : options.files) {
    SceneFile read = read_scene_file(file, options.scene.read_options());
    auto* test = std::get_if<Chi2Test>(&read);
    if (test == nullptr) {
      throw Error(ErrorKind::scene, fmt::format("{}: holds no <test type=\"chi2test\">; use 'etendue {}'.", file,
                                                std::holds_alternative<TTest>(read) ? "ttest" : "render"));
    }
    tests.push_back(std::move(*test));
  }
  bool passed = true;
  auto out = Json::array();
  std::vector<JunitCase> cases;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const Chi2Report report = run_chi2(tests[i], options.files[i], options.device.probe_factory(), options.test);
    passed = passed && report.passed();
    for (JunitCase& junit : chi2_junit(report)) cases.push_back(std::move(junit));
    out.push_back(chi2_json(report));
    if (options.results.wants_text()) {
      print_result("{}\n", chi2_table(report));
      std::fflush(stdout);
    }
  }
  OutputWriter files;
  options.results.write_json(files, [&] { return out; });
  write_text(files, options.results.junit, [&] { return junit_xml("chi2", cases); });
  files.finish();
  return passed ? Ending::ok : Ending::failed;
}

}  // namespace

void add_chi2_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("chi2", "test whether the sampling of bsdfs matches their density");
  const auto options = std::make_shared<Chi2Arguments>();
  command->add_option("FILE", options->files, "files with a <test type=\"chi2test\">")->required()->file({".xml"});
  options->scene.add_to(*command);
  options->device.add_to(*command);
  command->add_option("--seed", options->test.seed, "seed of the first test: its direction and its samples")
      ->capture_default_str();
  command->add_option("--samples", options->test.sample_count, "samples per test instead of the file's sampleCount")
      ->check(positive());
  command->add_flag("--allow-untested", options->test.allow_untested,
                    "exit with 0 even if there were too few samples for a test");
  options->results.add_to(*command);
  options->results.add_junit(*command);
  command->callback([&action, options] { action = [options] { return run_files(*options); }; });
}

}  // namespace etendue::cli
