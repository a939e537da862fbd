/// Merging shards gives what one render of the same samples gives, byte for byte, or an error that names the
/// difference.

#include <algorithm>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "image/merge.h"
#include "image_testing.h"

namespace etendue {
namespace {

using testing_image::error_of;
using testing_image::slurp;
using testing_image::spill;
using testing_image::synthetic_film;
using testing_image::TempFolder;

void expect_mentions(const std::string& sentence, const std::string& words) {
  EXPECT_NE(sentence.find(words), std::string::npos) << sentence << "\n  should mention: " << words;
}

/// Writes shards of the given ranges and returns their paths.
std::vector<std::string> write_shards(const TempFolder& folder, const std::vector<SampleRanges>& shards) {
  std::vector<std::string> paths;
  for (const SampleRanges& samples : shards) {
    paths.push_back(folder / ("shard" + std::to_string(paths.size()) + ".exr"));
    write_film(paths.back(), synthetic_film(13, 7, samples));
  }
  return paths;
}

TEST(Merge, EqualsOneRenderByteForByteInAnyOrder) {
  const TempFolder folder;
  std::vector<std::string> paths = write_shards(folder, {{{0, 5}}, {{5, 6}}, {{6, 20}}, {{20, 33}}});
  write_film(folder / "whole.exr", synthetic_film(13, 7, {{0, 33}}));
  const std::string whole = slurp(folder / "whole.exr");
  std::sort(paths.begin(), paths.end());
  do {
    write_film(folder / "merged.exr", merge_films(paths));
    ASSERT_EQ(slurp(folder / "merged.exr"), whole);
  } while (std::next_permutation(paths.begin(), paths.end()));
}

TEST(Merge, IsTheSameInMemory) {
  const TempFolder folder;
  const FilmFile left = synthetic_film(13, 7, {{0, 5}, {9, 12}}), right = synthetic_film(13, 7, {{5, 9}});
  const std::vector<const FilmFile*> films = {&right, &left};
  write_film(folder / "merged.exr", merge_loaded_films(films));
  write_film(folder / "whole.exr", synthetic_film(13, 7, {{0, 12}}));
  EXPECT_EQ(slurp(folder / "merged.exr"), slurp(folder / "whole.exr"));
  const std::vector<const FilmFile*> twice = {&left, &left};
  const std::string sentence = error_of([&] { merge_loaded_films(twice); });
  EXPECT_NE(sentence.find("film 1 and film 2 both hold the samples 0:5"), std::string::npos) << sentence;
}

TEST(Merge, RecordsGaps) {
  const TempFolder folder;
  const auto paths = write_shards(folder, {{{40, 48}, {60, 61}}, {{0, 8}}, {{8, 9}, {50, 52}}});
  write_film(folder / "whole.exr", synthetic_film(13, 7, {{0, 9}, {40, 48}, {50, 52}, {60, 61}}));
  const FilmFile merged = merge_films(paths);
  EXPECT_EQ(merged.metadata.at("samples"), "0:9,40:48,50:52,60:61");
  write_film(folder / "merged.exr", merged);
  EXPECT_EQ(slurp(folder / "merged.exr"), slurp(folder / "whole.exr"));
}

TEST(Merge, DoesNotMindHowItIsGrouped) {
  const TempFolder folder;
  const auto paths = write_shards(folder, {{{0, 2}}, {{2, 4}}, {{4, 6}}, {{6, 8}}});
  // Devices differ, so that the lists are merged too.
  for (std::size_t i = 0; i < paths.size(); ++i) {
    FilmFile file = read_film(paths[i]);
    file.metadata["device"] = i % 2 == 0 ? "GPU [x]; 2" : "CPU (LLVM 15, 256 bits)";
    write_film(paths[i], file);
  }
  write_film(folder / "left.exr", merge_films({paths[3], paths[0]}));
  write_film(folder / "right.exr", merge_films({paths[1], paths[2]}));
  write_film(folder / "twice.exr", merge_films({folder / "right.exr", folder / "left.exr"}));
  write_film(folder / "once.exr", merge_films(paths));
  EXPECT_EQ(slurp(folder / "twice.exr"), slurp(folder / "once.exr"));
  EXPECT_EQ(read_film(folder / "once.exr").metadata.at("device"),
            "GPU [x]; 2 [0:2,4:6]; CPU (LLVM 15, 256 bits) [2:4,6:8]");
  EXPECT_EQ(read_film(folder / "once.exr").metadata.at("driver"), "D 1");
}

TEST(Merge, OneFilmStaysAsItIs) {
  const TempFolder folder;
  const auto paths = write_shards(folder, {{{3, 5}, {7, 9}}});
  write_film(folder / "merged.exr", merge_films(paths));
  EXPECT_EQ(slurp(folder / "merged.exr"), slurp(paths[0]));
}

TEST(Merge, AFilmWithoutSamplesAddsNothing) {
  const TempFolder folder;
  auto paths = write_shards(folder, {{}, {{3, 5}}});
  FilmFile empty = read_film(paths[0]);
  empty.metadata["device"] = "B";
  write_film(paths[0], empty);
  write_film(folder / "merged.exr", merge_films(paths));
  EXPECT_EQ(slurp(folder / "merged.exr"), slurp(paths[1]));
}

TEST(Merge, RefusesSharedSamples) {
  const TempFolder folder;
  const auto paths = write_shards(folder, {{{0, 4}, {10, 20}}, {{4, 8}}, {{15, 30}}});
  const std::string sentence = error_of([&] { merge_films(paths); });
  expect_mentions(sentence, paths[0]);
  expect_mentions(sentence, paths[2]);
  expect_mentions(sentence, "15:20");
  EXPECT_EQ(sentence.find(paths[1]), std::string::npos) << sentence;
  const std::string twice = error_of([&] { merge_films({paths[1], paths[1]}); });
  expect_mentions(twice, "4:8");
}

TEST(Merge, NamesTheDifference) {
  const TempFolder folder;
  const auto paths = write_shards(folder, {{{0, 1}}, {{1, 2}}});
  const auto refusal = [&](const std::function<void(FilmFile&)>& change) {
    FilmFile file = synthetic_film(13, 7, {{1, 2}});
    change(file);
    write_film(paths[1], file);
    std::string sentence = error_of([&] { merge_films(paths); });
    expect_mentions(sentence, paths[0]);
    expect_mentions(sentence, paths[1]);
    return sentence;
  };
  for (const auto& [key, here] : {std::pair<std::string, std::string>{"version", "0.1.0"},
                                  {"sceneHash", "00c0ffee"},
                                  {"seed", "7"},
                                  {"integrator", "path maxDepth=16"}}) {
    const std::string name = key;
    const std::string other = refusal([&](FilmFile& file) { file.metadata[name] = "other"; });
    expect_mentions(other, '"' + here + '"');
    expect_mentions(other, "\"other\"");
    expect_mentions(refusal([&](FilmFile& file) { file.metadata.erase(name); }), "none");
  }
  const std::string size = refusal([](FilmFile& file) { file.film = synthetic_film(7, 13, {{1, 2}}).film; });
  expect_mentions(size, "13x7");
  expect_mentions(size, "7x13");
  const std::string exponent = refusal([](FilmFile& file) {
    file.film = Film(13, 7, 5);
    for (FilmPixel& pixel : file.film.pixels()) pixel.add(glm::vec3(1.0f), 5);
  });
  expect_mentions(exponent, "5");
  expect_mentions(exponent, "3");
}

TEST(Merge, KeepsWhatAllAgreeOnAndDropsTheRest) {
  const TempFolder folder;
  const auto paths = write_shards(folder, {{{8, 9}}, {{0, 1}}});
  FilmFile late = read_film(paths[0]);
  late.metadata["scene"] = "/elsewhere/box.xml";
  late.metadata["host"] = "one";
  late.metadata["note"] = "same";
  write_film(paths[0], late);
  FilmFile early = read_film(paths[1]);
  early.metadata["host"] = "two";
  early.metadata["note"] = "same";
  write_film(paths[1], early);
  const Metadata merged = merge_films(paths).metadata;
  EXPECT_EQ(merged.at("scene"), "box.xml") << "of the film with the lowest sample";
  EXPECT_EQ(merged.at("note"), "same");
  EXPECT_FALSE(merged.contains("host"));
}

TEST(Merge, RefusesDamagedAndForeignFiles) {
  const TempFolder folder;
  auto paths = write_shards(folder, {{{0, 1}}, {{1, 2}}});
  const std::string whole = slurp(paths[1]);
  spill(paths[1], whole.substr(0, whole.size() - 100));
  expect_mentions(error_of([&] { merge_films(paths); }), paths[1]);
  write_exr(paths[1], image_from_film(read_film(paths[0]).film, {}));
  expect_mentions(error_of([&] { merge_films(paths); }), "holds no film");
  paths[1] = folder / "none.exr";
  expect_mentions(error_of([&] { merge_films(paths); }), "none.exr");
  error_of([&] { merge_films({}); }, ErrorKind::usage);
}

/// A figure of /proc/self/status in KiB; 0 when there is none.
long process_memory(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return std::stol(line.substr(name.size() + 1));
  }
  return 0;
}

TEST(Merge, NeedsMemoryForAFewFilmsOnly) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers keep memory that is freed";
#endif
  const TempFolder folder;
  constexpr std::uint32_t kShards = 40;
  std::vector<std::string> paths;
  for (std::uint32_t i = 0; i < kShards; ++i) {
    paths.push_back(folder / (std::to_string(i) + ".exr"));
    write_film(paths.back(), synthetic_film(320, 240, {{i, i + 1}}));
  }
  std::ofstream("/proc/self/clear_refs") << "5";  // sets the peak back to the present size
  const long before = process_memory("VmRSS");
  if (before == 0 || process_memory("VmHWM") > before + 1000)
    GTEST_SKIP() << "the peak of memory cannot be measured here";
  const FilmFile merged = merge_films(paths);
  const long grown = process_memory("VmHWM") - before;
  const long film = static_cast<long>(merged.film.pixels().size() * sizeof(FilmPixel) / 1024);
  EXPECT_EQ(sample_count(merged.samples), kShards);
  EXPECT_LT(grown, 4 * film) << "KiB for " << kShards << " films of " << film << " KiB";
}

}  // namespace
}  // namespace etendue
