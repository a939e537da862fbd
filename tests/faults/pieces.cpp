/// A render in pieces ends in the bytes of one go: shards, resumed runs, kills, several devices.

#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <random>

#include "render_fixture.h"

namespace etendue::faults {

namespace {

using testing::HasSubstr;

class Pieces : public RenderTest {};

TEST_F(Pieces, ShardsInAnyOrderMakeTheFilmOfOneRender) {
  expect_ok(render({"--spp", "12", "--film", "-o", "one.exr", "-o", "one.png"}));
  expect_ok(render({"--samples", "0:5", "-o", "a.exr"}));
  expect_ok(render({"--samples", "5:6", "-o", "b.exr"}));
  expect_ok(render({"--samples", "6:12", "-o", "c.exr"}));
  expect_ok({"merge", "c.exr", "a.exr", "b.exr", "-o", "all.exr", "-o", "all.png"});
  expect_same("one.exr", "all.exr");
  expect_same("one.png", "all.png");
  expect_ok({"merge", "b.exr", "c.exr", "-o", "bc.exr"});
  expect_ok({"merge", "bc.exr", "a.exr", "-o", "tree.exr"});
  expect_same("one.exr", "tree.exr");
}

TEST_F(Pieces, MergedPictureIsThePictureOfOneRender) {
  expect_ok(render({"--spp", "6", "-o", "one.exr"}));
  expect_ok(render({"--samples", "0:3", "-o", "a.exr"}));
  expect_ok(render({"--samples", "3:6", "-o", "b.exr"}));
  expect_ok({"merge", "a.exr", "b.exr", "--picture", "-o", "all.exr"});
  expect_same("one.exr", "all.exr");
}

TEST_F(Pieces, GapsAreAllowedAndRecorded) {
  expect_ok(render({"--samples", "0:2", "-o", "a.exr"}));
  expect_ok(render({"--samples", "4:6", "-o", "c.exr"}));
  const ProcessResult result = run({"merge", "c.exr", "a.exr", "-o", "all.exr", "--json"});
  EXPECT_EQ(result.code, 0);
  EXPECT_THAT(result.out, HasSubstr("\"samples\": \"0:2,4:6\""));
  EXPECT_THAT(result.out, HasSubstr("\"missing\": 2"));
}

TEST_F(Pieces, MergeRefusesWhatDoesNotFit) {
  expect_ok(render({"--samples", "0:4", "-o", "a.exr"}));
  expect_ok(render({"--samples", "3:6", "-o", "overlap.exr"}));
  expect_ok(render({"--samples", "4:6", "--seed", "7", "-o", "seed.exr"}));
  expect_ok(render({"--samples", "4:6", "-D", "integrator.mis=false", "-o", "integrator.exr"}));
  expect_ok({"render", kScene, "--size", "41x30", "--samples", "4:6", "-o", "size.exr"});
  const std::string other_scene = SCENES_DIR "/bubble.xml";
  expect_ok({"render", other_scene, "--size", "40x30", "--samples", "4:6", "-o", "scene.exr"});
  expect_ok(render({"--spp", "4", "-o", "picture.exr"}));
  write_text(folder_ / "text.exr", "not an image");
  write_text(folder_ / "old.exr", "old");
  const std::pair<const char*, const char*> cases[] = {{"overlap.exr", "both hold the samples 3:4"},
                                                       {"seed.exr", "seeds"},
                                                       {"integrator.exr", "integrator settings"},
                                                       {"size.exr", "sizes"},
                                                       {"scene.exr", "scenes"},
                                                       {"picture.exr", "holds no film"},
                                                       {"text.exr", "not an EXR"},
                                                       {"missing.exr", "No such file"}};
  for (const auto& [file, words] : cases) {
    SCOPED_TRACE(file);
    expect_error(run({"merge", "a.exr", file, "-o", "old.exr"}), 6, words);
    EXPECT_EQ(read_text(folder_ / "old.exr"), "old");
  }
}

TEST_F(Pieces, ResumeGoesOnToMoreSamples) {
  expect_ok(render({"--spp", "20", "--film", "-o", "one.exr"}));
  expect_ok(render({"--spp", "7", "--checkpoint", "ck.exr", "-o", "short.exr"}));
  expect_ok(render({"--spp", "20", "--resume", "ck.exr", "--film", "-o", "all.exr"}));
  expect_same("one.exr", "all.exr");
  // Nothing left to do is not an error.
  expect_ok(render({"--spp", "20", "--resume", "all.exr", "--film", "-o", "again.exr"}));
  expect_same("one.exr", "again.exr");
}

TEST_F(Pieces, ResumeFillsGaps) {
  expect_ok(render({"--spp", "9", "--film", "-o", "one.exr"}));
  expect_ok(render({"--samples", "2:3", "-o", "a.exr"}));
  expect_ok(render({"--samples", "5:8", "-o", "b.exr"}));
  expect_ok({"merge", "a.exr", "b.exr", "-o", "gaps.exr"});
  expect_ok(render({"--spp", "9", "--resume", "gaps.exr", "--film", "-o", "all.exr"}));
  expect_same("one.exr", "all.exr");
}

TEST_F(Pieces, ResumeRefusesForeignTornAndTamperedFiles) {
  expect_ok(render({"--spp", "4", "--checkpoint", "ck.exr", "-o", "x.exr"}));
  const std::string whole = read_text(folder_ / "ck.exr");
  write_text(folder_ / "torn.exr", whole.substr(0, whole.size() / 2));
  write_text(folder_ / "empty.exr", "");
  std::string tampered = whole;
  tampered[tampered.size() - 40] = static_cast<char>(tampered[tampered.size() - 40] ^ 1);
  write_text(folder_ / "tampered.exr", tampered);
  expect_error(run(render({"--resume", "torn.exr", "-o", "y.exr"})), 6, "truncated or was changed");
  expect_error(run(render({"--resume", "tampered.exr", "-o", "y.exr"})), 6, "truncated or was changed");
  expect_error(run(render({"--resume", "empty.exr", "-o", "y.exr"})), 6, "empty.exr");
  expect_error(run(render({"--resume", "ck.exr", "--seed", "1", "-o", "y.exr"})), 6, "seeds");
  expect_error(run(render({"--resume", "x.exr", "-o", "y.exr"})), 6, "holds no film");
  expect_error(run(render({"--resume", "ck.exr", "--spp", "3", "-o", "y.exr"})), 2, "only 0:3 were requested");
  EXPECT_FALSE(exists("y.exr"));
}

TEST_F(Pieces, TwoDevicesMakeTheFilmOfOne) {
  expect_ok(render({"--spp", "40", "--film", "-o", "one.exr"}));
  expect_ok(render({"--spp", "40", "--film", "--device", "0,0", "-o", "two.exr"}));
  expect_same("one.exr", "two.exr");
  expect_ok(render({"--spp", "40", "--film", "--device", "all", "-o", "all.exr"}));
  expect_error(run(render({"--device", "0,99", "-o", "x.exr"})), 4, "--device 99");
}

TEST_F(Pieces, TheFilmSaysWhichDeviceRenderedWhat) {
  expect_ok(render({"--samples", "0:2", "-o", "device.exr"}));
  expect_ok(render({"--samples", "2:5", "--device", "reference", "-o", "reference.exr"}));
  const ProcessResult result = run({"merge", "device.exr", "reference.exr", "-o", "both.exr", "--json"});
  EXPECT_THAT(result.out, HasSubstr("[0:2]; reference [2:5]"));
}

TEST_F(Pieces, ErrorBoundStopsAtTheSameSampleWhateverHappens) {
  expect_ok(render({"--until-error", "60%", "--spp", "3000", "--film", "-o", "one.exr"}));
  const int count = std::stoi(samples_of("one.exr"));
  ASSERT_GE(count, 16);
  ASSERT_LT(count, 3000);
  expect_ok(render({"--samples", "0:5", "-o", "start.exr"}));
  expect_ok(render({"--until-error", "60%", "--spp", "3000", "--resume", "start.exr", "--film", "-o", "resumed.exr",
                    "--device", "0,0"}));
  expect_same("one.exr", "resumed.exr");
}

TEST_F(Pieces, TimeBudgetIsKept) {
  const auto start = std::chrono::steady_clock::now();
  const ProcessResult result = run(render({"--spp", "10000000", "--time", "2s", "-o", "x.exr"}));
  const std::chrono::duration<double> used = std::chrono::steady_clock::now() - start;
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("stopped by --time 2s"));
  EXPECT_LT(used.count(), 20.0);  // the machine may be busy, but ten million samples take hours
  EXPECT_TRUE(exists("x.exr"));
}

TEST_F(Pieces, SignalsSaveWhatIsDone) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Process process(render({"--spp", "10000000", "--checkpoint", "ck.exr", "--checkpoint-every", "200ms",
                            "--pass-samples", "4", "--film", "-o", "x.exr"}),
                    folder_);
    ASSERT_TRUE(wait_until([&] { return exists("ck.exr"); }));
    EXPECT_FALSE(exists("x.exr"));
    process.signal(signal);
    const ProcessResult result = process.wait();
    EXPECT_EQ(result.code, 130) << result.err;
    expect_same("x.exr", "ck.exr");
    expect_ok(render({"--spp", samples_of("x.exr"), "--film", "-o", "one.exr"}));
    expect_same("x.exr", "one.exr");
    std::filesystem::remove(folder_ / "ck.exr");
    std::filesystem::remove(folder_ / "x.exr");
  }
}

TEST_F(Pieces, ASecondSignalAborts) {
  // The device hangs, so that the pass that the first signal lets finish never does.
  write_text(folder_ / "x.exr", "old");
  Process process(render({"--spp", "1000", "-o", "x.exr"}), folder_,
                  {.environment = {{"VK_LAYER_PATH", FAULT_LAYER_FOLDER},
                                   {"VK_INSTANCE_LAYERS", "VK_LAYER_ETENDUE_fault"},
                                   {"ETENDUE_FAULT", "hang"}}});
  std::this_thread::sleep_for(std::chrono::seconds(1));
  process.signal(SIGINT);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  EXPECT_TRUE(process.is_running());
  process.signal(SIGINT);
  EXPECT_EQ(process.wait(30.0).code, 130);
  EXPECT_EQ(read_text(folder_ / "x.exr"), "old");
}

TEST_F(Pieces, Usr1WritesBesideAPictureOfMoreSamples) {
  expect_ok(render({"--spp", "500", "--seed", "9", "-o", "x.exr"}));
  const std::string before = read_text(folder_ / "x.exr");
  Process process({"render", kScene, "--size", "40x30", "--spp", "10000000", "--pass-samples", "1", "-o", "x.exr"},
                  folder_);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  process.signal(SIGUSR1);  // answered after the first pass
  EXPECT_TRUE(wait_until([&] { return exists("x.partial.exr"); }));
  EXPECT_TRUE(read_text(folder_ / "x.exr") == before);
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait().code, 130);
}

TEST_F(Pieces, Usr1WritesTheCurrentImage) {
  Process process(render({"--spp", "10000000", "-o", "x.exr"}), folder_);
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_FALSE(exists("x.exr"));
  process.signal(SIGUSR1);
  ASSERT_TRUE(wait_until([&] { return exists("x.exr"); }));
  EXPECT_TRUE(process.is_running());
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait().code, 130);
}

/// Renders `spp` samples while it kills the renderer `kills` times at random instants, then lets it finish.
void render_with_kills(const std::filesystem::path& folder, std::vector<std::string> arguments, int kills,
                       std::mt19937& random) {
  arguments.insert(arguments.end(), {"--checkpoint", "ck.exr", "--checkpoint-every", "50ms", "--pass-samples", "4",
                                     "--film", "-o", "killed.exr", "-q"});
  int killed = 0;
  for (int run = 0; killed < kills; ++run) {
    ASSERT_LT(run, 20 * kills);
    std::vector<std::string> now = arguments;
    if (std::filesystem::exists(folder / "ck.exr")) now.insert(now.end(), {"--resume", "ck.exr"});
    Process process(now, folder);
    std::this_thread::sleep_for(std::chrono::milliseconds(std::uniform_int_distribution(0, 1500)(random)));
    process.signal(SIGKILL);
    const int code = process.wait().code;
    if (code == 0) {  // it had finished before: begin anew, the kills go on
      std::filesystem::remove(folder / "ck.exr");
      continue;
    }
    EXPECT_EQ(code, -SIGKILL);
    ++killed;
  }
  if (std::filesystem::exists(folder / "ck.exr")) arguments.insert(arguments.end(), {"--resume", "ck.exr"});
  EXPECT_EQ(etendue(arguments, folder).code, 0);
}

int soak_kills() {
  const char* text = std::getenv("ETENDUE_SOAK_KILLS");
  return text != nullptr ? std::atoi(text) : 5;
}

TEST_F(Pieces, KillsAtRandomInstantsChangeNothing) {
  std::mt19937 random(std::random_device{}());
  expect_ok(render({"--spp", "600", "--film", "-o", "one.exr"}));
  render_with_kills(folder_, render({"--spp", "600"}), soak_kills(), random);
  expect_same("one.exr", "killed.exr");
  expect_same("one.exr", "ck.exr");
}

TEST_F(Pieces, ShardsOfRandomSizeInRandomOrder) {
  std::mt19937 random(std::random_device{}());
  const int shards = soak_kills();
  expect_ok(render({"--spp", "64", "--film", "-o", "one.exr"}));
  std::vector<int> cuts = {0, 64};
  while (static_cast<int>(cuts.size()) < std::min(shards, 40) + 1) {
    const int cut = std::uniform_int_distribution(1, 63)(random);
    if (std::find(cuts.begin(), cuts.end(), cut) == cuts.end()) cuts.push_back(cut);
  }
  std::sort(cuts.begin(), cuts.end());
  std::vector<std::string> merge = {"merge", "-o", "all.exr"};
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const std::string name = "shard-" + std::to_string(i) + ".exr";
    expect_ok(render({"--samples", std::to_string(cuts[i - 1]) + ":" + std::to_string(cuts[i]), "-o", name}));
    merge.push_back(name);
  }
  std::shuffle(merge.begin() + 3, merge.end(), random);
  expect_ok(merge);
  expect_same("one.exr", "all.exr");
}

// The address sanitizer otherwise keeps 256 MB of what was freed.
const ProcessOptions kFreedMemoryIsFree = {
    .environment = {{"ASAN_OPTIONS", "quarantine_size_mb=0:thread_local_quarantine_size_kb=0"}}};

// How much the resident memory of a render grows while it saves a checkpoint after every pass.
std::int64_t growth(Process& process, const std::filesystem::path& checkpoint, double seconds) {
  // On a busy machine the kernel alone may take a minute to compile.
  EXPECT_TRUE(wait_until([&] { return std::filesystem::exists(checkpoint); }, 200.0));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const auto before = static_cast<std::int64_t>(process.resident());
  EXPECT_GT(before, 0);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  const auto after = static_cast<std::int64_t>(process.resident());
  process.signal(SIGTERM);
  EXPECT_EQ(process.wait().code, 130);
  return after - before;
}

TEST_F(Pieces, MemoryIsFlat) {
  // The reference, so that nothing but the job, its films and its files is measured.
  Process process(render({"--spp", "4000000000", "--checkpoint", "ck.exr", "--checkpoint-every", "1ms", "--device",
                          "reference", "-o", "x.exr"}),
                  folder_, kFreedMemoryIsFree);
  EXPECT_LT(growth(process, folder_ / "ck.exr", 3.0), std::int64_t{2} << 20);
}

TEST_F(Pieces, MemoryOfTheDeviceIsFlat) {
  // Many small dispatches: lavapipe copies and keeps a kernel for each when a loop's exit depends on uniform values
  // alone. With such a loop planted in choose_light_shape this test saw 287 MB.
  Process process(render({"--spp", "4000000000", "--pass-samples", "1", "--checkpoint", "ck.exr", "--checkpoint-every",
                          "1s", "-o", "x.exr"}),
                  folder_, kFreedMemoryIsFree);
  EXPECT_LT(growth(process, folder_ / "ck.exr", 4.0), std::int64_t{4} << 20);
}

TEST_F(Pieces, SoakMemoryOfTheDeviceIsFlat) {
  // The target soak watches for an hour.
  const char* minutes = std::getenv("ETENDUE_SOAK_MINUTES");
  const double seconds = minutes != nullptr ? 60.0 * std::atof(minutes) : 12.0;
  Process process(render({"--spp", "4000000000", "--checkpoint", "ck.exr", "--checkpoint-every", "5s", "-o", "x.exr"}),
                  folder_, kFreedMemoryIsFree);
  EXPECT_LT(growth(process, folder_ / "ck.exr", seconds), std::int64_t{16} << 20);
}

// The paths of a set belong together: a piece of a render takes whole sets, and only those make the bytes of one
// render.
TEST_F(Pieces, SetsOfPathsAreNotCut) {
  write_text(folder_ / "sets.xml", R"(<scene>
    <sampler type="sobol"><integer name="sampleCount" value="24"/><integer name="setSize" value="8"/></sampler>
    <integrator type="path"/>
    <camera type="perspective"><integer name="width" value="9"/><integer name="height" value="7"/></camera>
    <color name="sky_top" value="1, 2, 3"/>
    <mesh type="sphere"><point name="center" value="0, 0, 4"/><bsdf type="diffuse"/></mesh>
  </scene>)");
  const ProcessResult cut = run({"render", "sets.xml", "--samples", "0:7", "-o", "a.exr"});
  EXPECT_EQ(cut.code, 2);
  EXPECT_THAT(cut.err, HasSubstr("cuts a set of the sobol sampler, whose sets have 8 samples"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.exr"));
  expect_ok({"render", "sets.xml", "--samples", "0:8", "-o", "a.exr"});
  expect_ok({"render", "sets.xml", "--samples", "8:24", "-o", "b.exr"});
  expect_ok({"render", "sets.xml", "--film", "-o", "one.exr"});
  const ProcessResult merged = run({"merge", "a.exr", "b.exr", "-o", "all.exr"});
  EXPECT_EQ(merged.code, 0);
  EXPECT_THAT(merged.err, HasSubstr("3 sets of paths per pixel (sobol setSize=8)"));
  expect_same("one.exr", "all.exr");
}

TEST_F(Pieces, BadNumbersAreRefusedBeforeAnythingIsDone) {
  const std::vector<std::vector<std::string>> cases = {{"--samples", "4"},
                                                       {"--samples", "4:4"},
                                                       {"--samples", "5:4"},
                                                       {"--samples", "-1:4"},
                                                       {"--samples", "0:4294967296"},
                                                       {"--samples", "0:4 "},
                                                       {"--samples", "0:8", "--spp", "7"},
                                                       {"--time", "10"},
                                                       {"--time", "0s"},
                                                       {"--time", "-1s"},
                                                       {"--time", "1e3s"},
                                                       {"--time", "10 m"},
                                                       {"--time", "infs"},
                                                       {"--until-error", "0"},
                                                       {"--until-error", "100%"},
                                                       {"--until-error", "1%%"},
                                                       {"--until-error", "nan"},
                                                       {"--checkpoint-every", "3s"},
                                                       {"--checkpoint", "ck.exr", "--checkpoint-every", "often"},
                                                       {"-o", "x.jpg"}};
  for (const std::vector<std::string>& more : cases) {
    SCOPED_TRACE(testing::PrintToString(more));
    const ProcessResult result = run(render(more));
    EXPECT_EQ(result.code, 2);
    EXPECT_EQ(result.errors().size(), 1u) << result.err;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace etendue::faults
