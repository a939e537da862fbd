/// Film files: exact round trips; anything torn, changed or foreign is refused.

#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "image/decode.h"
#include "image/film_file.h"
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

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

TEST(FilmFile, KeepsEveryBit) {
  const TempFolder folder;
  const FilmFile file = synthetic_film(33, 21, {{0, 3}, {10, 12}});
  write_film(folder / "a.exr", file);
  const FilmFile back = read_film(folder / "a.exr");
  EXPECT_EQ(back.film.width(), 33u);
  EXPECT_EQ(back.film.height(), 21u);
  EXPECT_EQ(back.film.exponent(), 3);
  EXPECT_EQ(back.film.pixels(), file.film.pixels());
  EXPECT_EQ(back.samples, file.samples);
  EXPECT_EQ(back.metadata, film_metadata(file));
  EXPECT_EQ(back.metadata.at("samples"), "0:3,10:12");
  EXPECT_EQ(back.metadata.at("rejected"), std::to_string(file.film.rejected()));
  EXPECT_GT(file.film.rejected(), 0u);
  write_film(folder / "b.exr", back);
  EXPECT_EQ(slurp(folder / "a.exr"), slurp(folder / "b.exr")) << "writing what was read changes nothing";
  EXPECT_EQ(folder.files(), 2u);
}

TEST(FilmFile, KeepsLimbsOfEveryHeight) {
  const TempFolder folder;
  FilmFile file = synthetic_film(3, 2, {{0, 2}});
  std::uint32_t word = 0x80000001u;
  for (FilmPixel& pixel : file.film.pixels()) {
    for (auto& sum : pixel.sum) {
      for (auto& limb : sum) limb = word *= 2654435769u;
    }
    for (auto& squares : pixel.sum_squares) {
      for (auto& limb : squares) limb = word *= 2654435769u;
    }
  }
  write_film(folder / "a.exr", file);
  EXPECT_EQ(read_film(folder / "a.exr").film.pixels(), file.film.pixels());
}

TEST(FilmFile, HoldsAFilmWithoutSamplesAndOneOfZeros) {
  const TempFolder folder;
  FilmFile file;
  file.film = Film(2, 2, -149);
  write_film(folder / "a.exr", file);
  EXPECT_TRUE(read_film(folder / "a.exr").samples.empty());
  for (FilmPixel& pixel : file.film.pixels()) pixel.add(glm::vec3(0.0f), -149);
  file.samples = {{0xfffffffeu, 0xffffffffu}};
  write_film(folder / "a.exr", file);
  EXPECT_EQ(read_film(folder / "a.exr").film.pixels(), file.film.pixels());
  EXPECT_EQ(read_film(folder / "a.exr").samples, file.samples);
}

TEST(FilmFile, IsAPictureToEveryoneElse) {
  const TempFolder folder;
  const FilmFile file = synthetic_film(8, 5, {{0, 6}});
  write_film(folder / "a.exr", file);
  const Image seen = read_image(folder / "a.exr"), shown = image_from_film(file.film, film_metadata(file));
  EXPECT_EQ(seen.pixels, shown.pixels);
  EXPECT_EQ(seen.standard_error, shown.standard_error);
  EXPECT_EQ(seen.sample_count, shown.sample_count);
  EXPECT_EQ(seen.metadata, shown.metadata);
}

TEST(FilmFile, HeaderIsReadWithoutThePixels) {
  const TempFolder folder;
  FilmFile file = synthetic_film(8, 5, {{0, 6}});
  file.metadata["integrator"] = std::string(100000, 'x');  // longer than the piece that is read first
  write_film(folder / "a.exr", file);
  const FilmHeader header = read_film_header(folder / "a.exr");
  EXPECT_EQ(header, header_of(read_film(folder / "a.exr")));
  EXPECT_EQ(header.metadata.at("integrator").size(), 100000u);
}

TEST(FilmFile, RefusesAnyChangedByte) {
  const TempFolder folder;
  write_film(folder / "a.exr", synthetic_film(16, 33, {{0, 4}}));
  const std::string whole = slurp(folder / "a.exr");
  int checked = 0;
  for (std::size_t i = 0; i < whole.size(); i += i < 2500 ? 1 : 37) {
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ (1 << (i % 8)));
    const std::string sentence = error_of([&] { decode_film(bytes_of(bytes), "film.exr", true); });
    EXPECT_EQ(sentence.find("film.exr: "), 0u) << "byte " << i << ": " << sentence;
    ++checked;
  }
  EXPECT_GT(checked, 2500);
}

TEST(FilmFile, SurvivesChangedBytesBehindTheChecksum) {
  const TempFolder folder;
  write_film(folder / "a.exr", synthetic_film(5, 3, {{0, 4}}));
  const std::string whole = slurp(folder / "a.exr");
  int refused = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const char value : {'\x00', '\xff', static_cast<char>(whole[i] ^ 1)}) {
      std::string bytes = whole;
      bytes[i] = value;
      try {
        const FilmFile file = decode_film(bytes_of(bytes), "film.exr", false);
        EXPECT_EQ(file.film.pixels().size(), std::size_t{file.film.width()} * file.film.height());
      } catch (const Error&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(FilmFile, RefusesEveryTruncation) {
  const TempFolder folder;
  write_film(folder / "a.exr", synthetic_film(16, 33, {{0, 4}}));
  const std::string whole = slurp(folder / "a.exr");
  for (std::size_t length = 0; length < whole.size(); length += length < 2500 ? 11 : 501) {
    spill(folder / "b.exr", whole.substr(0, length));
    error_of([&] { read_film(folder / "b.exr"); });
  }
  spill(folder / "b.exr", whole.substr(0, whole.size() - 1));
  expect_mentions(error_of([&] { read_film(folder / "b.exr"); }), "truncated");
  spill(folder / "b.exr", whole + "x");
  expect_mentions(error_of([&] { read_film(folder / "b.exr"); }), "changed");
}

TEST(FilmFile, RefusesHalfOfOneFilmAndHalfOfAnother) {
  const TempFolder folder;
  write_film(folder / "a.exr", synthetic_film(16, 33, {{0, 4}}));
  write_film(folder / "b.exr", synthetic_film(16, 33, {{4, 8}}));
  const std::string a = slurp(folder / "a.exr"), b = slurp(folder / "b.exr");
  const std::size_t half = std::min(a.size(), b.size()) / 2;
  spill(folder / "torn.exr", a.substr(0, half) + b.substr(half));
  expect_mentions(error_of([&] { read_film(folder / "torn.exr"); }), "checksum");
}

TEST(FilmFile, RefusesForeignFiles) {
  const TempFolder folder;
  const FilmFile file = synthetic_film(4, 4, {{0, 2}});
  write_exr(folder / "picture.exr", image_from_film(file.film, film_metadata(file)));
  expect_mentions(error_of([&] { read_film(folder / "picture.exr"); }), "holds no film");
  write_png(folder / "picture.png", image_from_film(file.film, {}));
  expect_mentions(error_of([&] { read_film(folder / "picture.png"); }), "holds no film");
  spill(folder / "empty.exr", "");
  expect_mentions(error_of([&] { read_film(folder / "empty.exr"); }), "holds no film");
  expect_mentions(error_of([&] { read_film(folder / "none.exr"); }), "No such file");
  // A film that was read and written as a picture is no film any more, though its metadata came along.
  write_film(folder / "film.exr", file);
  write_exr(folder / "copy.exr", read_image(folder / "film.exr"));
  expect_mentions(error_of([&] { read_film(folder / "copy.exr"); }), "holds no film");
}

TEST(FilmFile, RefusesOtherFormatsAndContradictions) {
  const TempFolder folder;
  write_film(folder / "a.exr", synthetic_film(4, 4, {{0, 2}}));
  const std::string whole = slurp(folder / "a.exr");
  const auto with = [&](const std::string& after, std::size_t offset, const std::string& value) {
    std::string bytes = whole;
    bytes.replace(bytes.find(after) + after.size() + offset, value.size(), value);
    return error_of([&] { decode_film(bytes_of(bytes), "film.exr", false); });
  };
  const std::string integer = std::string("\0int\0\4\0\0\0", 9);
  expect_mentions(with("filmFormat" + integer, 0, std::string("\3\0\0\0", 4)), "format 3");
  expect_mentions(with("filmExponent" + integer, 0, std::string("\xe8\3\0\0", 4)), "1000");
  const std::string samples = std::string("samples\0string\0\3\0\0\0", 19);
  expect_mentions(with(samples, 0, "0:3"), "2 samples");
  expect_mentions(with(samples, 0, "2:0"), "2:0");
  expect_mentions(with(samples, 0, "0,2"), "0,2");
}

TEST(FilmFile, RefusesToWriteWhatItCouldNotRead) {
  const TempFolder folder;
  FilmFile file = synthetic_film(4, 4, {{0, 2}});
  file.samples = {{0, 3}};
  expect_mentions(error_of([&] { write_film(folder / "a.exr", file); }), "(0, 0)");
  file.samples = {{1, 2}, {0, 1}};
  expect_mentions(error_of([&] { write_film(folder / "a.exr", file); }), "sorted");
  file.samples = {{0, 2}};
  file.metadata["filmFormat"] = "1";
  expect_mentions(error_of([&] { write_film(folder / "a.exr", file); }), "filmFormat");
  file.metadata.erase("filmFormat");
  file.metadata["filmAovs"] = "depth:0";
  expect_mentions(error_of([&] { write_film(folder / "a.exr", file); }), "filmAovs");
  error_of([&] { write_film(folder / "a.exr", FilmFile{}); });
  EXPECT_EQ(folder.files(), 0u);
}

TEST(FilmFile, KeepsTheOldCheckpointWhenTheNewOneDoesNotFit) {
  const TempFolder folder;
  const FilmFile before = synthetic_film(16, 16, {{0, 1}});
  write_film(folder / "a.exr", before);
  const std::string bytes = slurp(folder / "a.exr");
  rlimit old;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &old), 0);
  const rlimit limit{bytes.size() / 2, old.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  const std::string sentence = error_of([&] { write_film(folder / "a.exr", synthetic_film(16, 16, {{0, 9}})); });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &old), 0);
  expect_mentions(sentence, "File too large");
  EXPECT_EQ(slurp(folder / "a.exr"), bytes);
  EXPECT_EQ(folder.files(), 1u);
}

TEST(SampleRanges, TextGoesBothWays) {
  const SampleRanges ranges = {{0, 64}, {128, 192}, {4294967294u, 4294967295u}};
  EXPECT_EQ(to_text(ranges), "0:64,128:192,4294967294:4294967295");
  EXPECT_EQ(parse_sample_ranges(to_text(ranges)), ranges);
  EXPECT_EQ(parse_sample_ranges(""), SampleRanges{});
  for (const char* text : {"0", "0:", ":1", "0:1,", ",0:1", "1:1", "2:1", "0:2,2:3", "0:2,1:3", "3:4,0:1", "00:1",
                           "0:1 ", " 0:1", "+0:1", "-1:1", "0:4294967296", "0:1;2:3", "0:1:2", "a:b"}) {
    EXPECT_FALSE(parse_sample_ranges(text).has_value()) << text;
  }
}

TEST(SampleRanges, JoinsNeighbours) {
  EXPECT_EQ(canonical({{5, 6}, {0, 2}, {9, 9}, {2, 4}}), (SampleRanges{{0, 4}, {5, 6}}));
  EXPECT_EQ(sample_count({{0, 4}, {5, 6}}), 5u);
}

}  // namespace
}  // namespace etendue
