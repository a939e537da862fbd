/// What is rendered beside a picture: names, averages, and its way through film files and merges.

#include <algorithm>
#include <array>
#include <span>

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include "image/decode.h"
#include "image/film_file.h"
#include "image/merge.h"
#include "image_testing.h"

namespace etendue {
namespace {

using testing_image::error_of;
using testing_image::slurp;
using testing_image::spill;
using testing_image::synthetic_film;
using testing_image::TempFolder;

constexpr std::uint32_t kWidth = 13, kHeight = 7;

/// A ray of this sample meets something.
bool hits(std::uint64_t pixel, std::uint32_t sample) {
  return testing_image::hash(pixel * 131 + sample) % 3 != 0;
}

glm::vec3 aov_sample(Aov aov, std::uint64_t pixel, std::uint32_t sample) {
  if (!hits(pixel, sample)) return glm::vec3(0.0f);
  const auto word = static_cast<std::uint32_t>(testing_image::hash(pixel * 7919 + sample * 31 + 5));
  if (aov == Aov::hit) return glm::vec3(1.0f);
  if (aov == Aov::instance) return {word & 0xffffu, word >> 16, 0.0f};
  return glm::vec3(static_cast<float>(word >> 8) * 0x1p-20f, 0.0f, 0.0f);
}

/// Depths and numbers, as a renderer would make them: of numbers the first sample alone.
FilmFile film_with_aovs(const SampleRanges& samples) {
  FilmFile file = synthetic_film(kWidth, kHeight, samples);
  for (const Aov aov : {Aov::hit, Aov::depth, Aov::instance}) {
    const int exponent = aov == Aov::depth ? 4 : 0;
    Film film(kWidth, kHeight, exponent);
    for (std::size_t i = 0; i < film.pixels().size(); ++i) {
      for (const auto& [begin, end] : samples) {
        for (std::uint32_t s = begin; s < end; ++s) {
          if (aov != Aov::instance || s == samples.front().first) film.pixels()[i].add(aov_sample(aov, i, s), exponent);
        }
      }
    }
    file.aovs.push_back({aov, std::move(film)});
  }
  return file;
}

TEST(Aovs, AreNamedOnceAndComeWithWhatTheirAveragesNeed) {
  EXPECT_EQ(parse_aovs("normal, depth,albedo"), (std::vector{Aov::normal, Aov::depth, Aov::albedo}));
  EXPECT_TRUE(parse_aovs("").empty());
  EXPECT_EQ(complete({Aov::normal, Aov::depth, Aov::depth}), (std::vector{Aov::hit, Aov::depth, Aov::normal}));
  EXPECT_EQ(complete({Aov::albedo}), (std::vector{Aov::albedo}));
  for (const char* wrong : {"depht", "depth,,normal", "hit", " ", "depth normal"}) {
    const std::string sentence = error_of([&] { parse_aovs(wrong); }, ErrorKind::usage);
    EXPECT_NE(sentence.find("shading_normal"), std::string::npos) << sentence;
  }
  for (const AovTraits& row : all_aovs()) EXPECT_EQ(aov_named(row.name), row.aov);
}

TEST(Aovs, DepthIsThatOfTheRaysThatHit) {
  const FilmFile file = film_with_aovs({{0, 3}});
  const std::vector<ImageChannel> channels = channels_of(file.aovs);
  ASSERT_EQ(channels.size(), 2u);
  EXPECT_EQ(channels[0].name, "depth.Z");
  std::size_t missed = 0;
  for (std::size_t i = 0; i < kWidth * kHeight; ++i) {
    double sum = 0.0, count = 0.0;
    for (std::uint32_t s = 0; s < 3; ++s) {
      sum += static_cast<double>(aov_sample(Aov::depth, i, s).x);
      count += hits(i, s) ? 1.0 : 0.0;
    }
    const double expected = count > 0.0 ? sum / count : 1e10;
    EXPECT_NEAR(static_cast<double>(channels[0].values[i]), expected, 1e-6 * expected);
    missed += count == 0.0 ? 1 : 0;
  }
  EXPECT_GT(missed, 0u) << "some pixel should be missed by all rays";
}

TEST(Aovs, NumbersAreThoseOfTheFirstSample) {
  const FilmFile file = film_with_aovs({{3, 9}});
  const std::vector<ImageChannel> channels = channels_of(file.aovs);
  EXPECT_EQ(channels[1].name, "instance.X");
  for (std::size_t i = 0; i < kWidth * kHeight; ++i) {
    const glm::vec3 halves = aov_sample(Aov::instance, i, 3);
    EXPECT_EQ(channels[1].numbers[i],
              static_cast<std::uint32_t>(halves.x) + 65536u * static_cast<std::uint32_t>(halves.y));
  }
}

TEST(Aovs, GoThroughFilmFilesAndMergesByteForByte) {
  const TempFolder folder;
  const std::vector<SampleRanges> shards = {{{0, 2}, {6, 7}}, {{2, 3}}, {{3, 6}, {9, 12}}};
  std::vector<std::string> paths;
  for (const SampleRanges& samples : shards) {
    paths.push_back(folder / ("shard" + std::to_string(paths.size()) + ".exr"));
    write_film(paths.back(), film_with_aovs(samples));
    const FilmFile read = read_film(paths.back());
    write_film(folder / "again.exr", read);
    EXPECT_EQ(slurp(folder / "again.exr"), slurp(paths.back()));
    EXPECT_EQ(read_film_header(paths.back()), header_of(read));
  }
  write_film(folder / "whole.exr", film_with_aovs({{0, 7}, {9, 12}}));
  do {
    write_film(folder / "merged.exr", merge_films(paths));
    ASSERT_EQ(slurp(folder / "merged.exr"), slurp(folder / "whole.exr"));
  } while (std::next_permutation(paths.begin(), paths.end()));
}

TEST(Aovs, ListsThatNoFilmHasAreRefused) {
  const TempFolder folder;
  write_film(folder / "film.exr", film_with_aovs({{0, 2}}));
  const std::string whole = slurp(folder / "film.exr"), list = "hit:0 depth:4 instance:0";
  ASSERT_NE(whole.find(list), std::string::npos);
  for (const char* wrong : {"hit:0 depth:4 instance:x", "hit:0 depht:4 instance:0", "depth:4 hit:0 instance:0",
                            "hit:0 depth:+ instance:0", "hit:0 depth:4,instance:0", "hit:0 depth:4 instance:9"}) {
    std::string bytes = whole;
    bytes.replace(bytes.find(list), list.size(), wrong);
    const auto decode = [&] { decode_film(std::as_bytes(std::span(bytes)), "film.exr", false); };
    if (std::string(wrong).ends_with("9")) {
      EXPECT_NO_THROW(decode()) << "another exponent is no fault";
    } else {
      EXPECT_NE(error_of(decode).find("list of AOVs"), std::string::npos) << wrong;
    }
  }
}

TEST(Aovs, AreNotMergedWithOthers) {
  const TempFolder folder;
  write_film(folder / "with.exr", film_with_aovs({{0, 2}}));
  write_film(folder / "without.exr", synthetic_film(kWidth, kHeight, {{2, 4}}));
  const std::string sentence = error_of([&] { merge_films({folder / "with.exr", folder / "without.exr"}); });
  EXPECT_NE(sentence.find("different AOVs"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find("hit,depth,instance"), std::string::npos) << sentence;
}

TEST(Aovs, FilmsWithoutThemKeepTheirFormat) {
  const TempFolder folder;
  write_film(folder / "film.exr", synthetic_film(kWidth, kHeight, {{0, 2}}));
  EXPECT_EQ(slurp(folder / "film.exr").find("filmAovs"), std::string::npos);
  EXPECT_TRUE(read_film(folder / "film.exr").aovs.empty());
}

TEST(Aovs, CountsThatDoNotFitAreRefused) {
  const TempFolder folder;
  FilmFile file = film_with_aovs({{0, 4}});
  file.aovs[1].film.pixels()[5].count = 3;
  const std::string sentence = error_of([&] { write_film(folder / "film.exr", file); });
  EXPECT_NE(sentence.find("3 samples of depth"), std::string::npos) << sentence;
  file = film_with_aovs({{0, 4}});
  file.aovs[2].film.pixels()[5].count = 4;
  EXPECT_NE(error_of([&] { write_film(folder / "film.exr", file); }).find("4 samples of instance"), std::string::npos);
}

TEST(Aovs, PicturesHaveLayersOfTheirNames) {
  const TempFolder folder;
  write_exr(folder / "picture.exr", image_from_film(film_with_aovs({{0, 4}})));
  const Imf::InputFile file((folder / "picture.exr").c_str());
  const Imf::ChannelList& channels = file.header().channels();
  ASSERT_NE(channels.findChannel("depth.Z"), nullptr);
  EXPECT_EQ(channels["depth.Z"].type, Imf::FLOAT);
  ASSERT_NE(channels.findChannel("instance.X"), nullptr);
  EXPECT_EQ(channels["instance.X"].type, Imf::UINT);
  EXPECT_EQ(channels.findChannel("hit"), nullptr);
  EXPECT_EQ(read_image(folder / "picture.exr").pixels.size(), std::size_t{kWidth * kHeight});
}

/// Red, green, blue and alpha of the first pixel.
std::array<png_byte, 4> first_pixel(const std::string& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_file(&image, path.c_str()), 0) << image.message;
  EXPECT_NE(image.format & PNG_FORMAT_FLAG_ALPHA, 0u);
  image.format = PNG_FORMAT_RGBA;
  std::vector<png_byte> bytes(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr), 0) << image.message;
  return {bytes[0], bytes[1], bytes[2], bytes[3]};
}

TEST(Aovs, PngsAreTransparentWhereAlphaIsLessThanOne) {
  const TempFolder folder;
  Image image{.width = 1, .height = 1, .pixels = {{0.25f, 0.125f, 0.0f}}};
  image.channels.push_back({.name = "A", .values = {0.25f}});
  write_png(folder / "a.png", image);
  // The colour is that of what covers a quarter: 1, 0.5 and 0 in linear light.
  EXPECT_EQ(first_pixel(folder / "a.png"), (std::array<png_byte, 4>{255, 188, 0, 64}));
  image.channels[0].values = {0.0f};
  write_png(folder / "b.png", image);
  EXPECT_EQ(first_pixel(folder / "b.png"), (std::array<png_byte, 4>{0, 0, 0, 0}));
}

}  // namespace
}  // namespace etendue
