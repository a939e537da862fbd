#include "validate/ttest.h"

#include <cstdio>

#include <fmt/core.h>

#include "cli/command.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "validate/chi2.h"

namespace etendue::cli {
namespace {

struct TTestArguments {
  std::vector<std::string> files;
  SceneOptions scene;
  DeviceOption device;
  TTestOptions test;
  SampleOptions sampling;
  ResultOptions results;
};

// --size, and what --size and --spp cannot mean.
void prepare(TTest& test, const std::string& file, const TTestArguments& options) {
  if (!test.bsdfs.empty() && (options.sampling.spp > 0 || !options.sampling.size.empty()))
    throw Error(
        ErrorKind::usage,
        fmt::format("{}: tests bsdfs, which have no pixels for --size and --spp; --samples says how many samples "
                    "each test takes.",
                    file));
  for (Scene& scene : test.scenes) options.sampling.set_size(scene);
}

Ending run_files(const TTestArguments& options) {
  options.results.begin();
  if (options.sampling.spp > 0 && options.test.sample_count)
    throw Error(ErrorKind::usage,
                "--spp gives the samples of each pixel and --samples those of all pixels together; give one of them.");
  TTestOptions settings = options.test;
  settings.seed = options.sampling.seed;
  if (options.sampling.spp > 0) settings.samples_per_pixel = options.sampling.spp;
  // All files are read before the first device is touched.
  std::vector<TTest> tests;
  for (const std::string& file : options.files) {
    SceneFile read = read_scene_file(file, options.scene.read_options());
    auto* test = std::get_if<TTest>(&read);
    if (test == nullptr) {
      throw Error(ErrorKind::scene,
                  fmt::format("{}: holds no <test type=\"ttest\">; use 'etendue render' for scenes.", file));
    }
    prepare(*test, file, options);
    tests.push_back(std::move(*test));
  }
  bool passed = true;
  auto out = Json::array();
  std::vector<JunitCase> cases;
  for (std::size_t i = 0; i < tests.size(); ++i) {
    const TTestReport report =
        tests[i].bsdfs.empty() ? run_ttest(tests[i], options.files[i], options.device.factory(), settings)
                               : run_bsdf_ttest(tests[i], options.files[i], options.device.probe_factory(), settings);
    passed = passed && report.passed();
    for (JunitCase& junit : ttest_junit(report)) cases.push_back(std::move(junit));
    out.push_back(ttest_json(report));
    if (options.results.wants_text()) {
      print_result("{}\n", ttest_table(report));
      std::fflush(stdout);
    }
  }
  OutputWriter files;
  options.results.write_json(files, [&] { return out; });
  write_text(files, options.results.junit, [&] { return junit_xml("ttest", cases); });
  files.finish();
  return passed ? Ending::ok : Ending::failed;
}

}  // namespace

void add_ttest_command(Command& app, Action& action) {
  auto* command =
      app.add_subcommand("ttest", "test the mean luminance of scenes, or the albedo of bsdfs, against known values");
  const auto options = std::make_shared<TTestArguments>();
  command->add_option("FILE", options->files, "files with a <test type=\"ttest\">")->required()->file({".xml"});
  options->scene.add_to(*command);
  options->device.add_to(*command);
  options->sampling.add_to(*command);
  command
      ->add_option("--samples", options->test.sample_count,
                   "samples per scene, for all pixels together, instead of the file's sampleCount")
      ->check(positive());
  command->add_flag("--allow-untested", options->test.allow_untested,
                    "exit with 0 even if there were too few samples for a test");
  options->results.add_to(*command);
  options->results.add_junit(*command);
  command->callback([&action, options] { action = [options] { return run_files(*options); }; });
}

}  // namespace etendue::cli
