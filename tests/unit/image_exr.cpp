/// EXR pictures: round trips, files of other programs, damaged files.

#include <cmath>
#include <cstring>
#include <limits>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include "image_testing.h"

namespace etendue {
namespace {

using testing_image::error_of;
using testing_image::slurp;
using testing_image::spill;
using testing_image::TempFolder;

Image test_image(std::uint32_t width, std::uint32_t height) {
  Image image;
  image.width = width;
  image.height = height;
  for (std::uint32_t i = 0; i < width * height; ++i) {
    image.pixels.push_back(testing_image::synthetic_sample(i, 0));
    image.standard_error.push_back(glm::abs(testing_image::synthetic_sample(i, 1)));
    image.sample_count.push_back(i * 7919u);
  }
  image.pixels[0] = glm::vec3(std::numeric_limits<float>::infinity(), -0.0f, std::numeric_limits<float>::denorm_min());
  image.metadata = {
      {"scene", "a box.xml"}, {"version", "1.2.3"},
      {"name", "ünïcode"},    {"type", ""},
      {"samples", "0:4"},     {"aVeryLongNameThatNeedsTheLongNamesFlagOfTheFormat", std::string(5000, 'x')}};
  return image;
}

/// Equal as bits, so that NaN equals itself and 0 differs from -0.
bool same_bits(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec3)) == 0;
}

/// Writes an EXR of another program: every channel holds 100 x + y + its index.
void write_foreign(const std::string& path, Imf::Header header,
                   const std::vector<std::pair<std::string, Imf::Channel>>& channels) {
  const Imath::Box2i window = header.dataWindow();
  const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
  std::vector<std::vector<float>> floats;
  Imf::FrameBuffer buffer;
  for (const auto& [name, channel] : channels) {
    header.channels().insert(name, channel);
    std::vector<float> values;
    values.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x)
        values.push_back(static_cast<float>(100 * x + y) + static_cast<float>(floats.size()));
    }
    floats.push_back(std::move(values));
  }
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const Imf::Channel& channel = channels[i].second;
    // The library needs the type of the file when it writes: halves and integers get their own copies.
    static std::vector<std::vector<half>> halves;
    if (channel.type == Imf::HALF) {
      halves.emplace_back(floats[i].begin(), floats[i].end());
      buffer.insert(channels[i].first,
                    Imf::Slice::Make(Imf::HALF, halves.back().data(), window, sizeof(half), sizeof(half) * width));
    } else {
      const auto samples = static_cast<std::size_t>(channel.xSampling);
      buffer.insert(channels[i].first,
                    Imf::Slice::Make(channel.type, floats[i].data(), window, sizeof(float),
                                     sizeof(float) * width / samples, channel.xSampling, channel.ySampling));
    }
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(height);
}

TEST(Exr, KeepsEveryBit) {
  const TempFolder folder;
  for (const auto& [width, height] :
       {std::pair{37u, 23u}, std::pair{1u, 1u}, std::pair{1u, 70u}, std::pair{300u, 2u}}) {
    const Image image = test_image(width, height);
    write_exr(folder / "a.exr", image);
    const Image back = read_image(folder / "a.exr");
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.height, height);
    EXPECT_TRUE(same_bits(back.pixels, image.pixels));
    EXPECT_TRUE(same_bits(back.standard_error, image.standard_error));
    EXPECT_EQ(back.sample_count, image.sample_count);
    EXPECT_EQ(back.metadata, image.metadata);
  }
  EXPECT_EQ(folder.files(), 1u);
}

TEST(Exr, IsTheSameBytesEveryTime) {
  const TempFolder folder;
  write_exr(folder / "a.exr", test_image(200, 100));
  write_exr(folder / "b.exr", test_image(200, 100));
  EXPECT_EQ(slurp(folder / "a.exr"), slurp(folder / "b.exr"));
}

TEST(Exr, WorksWithoutStatistics) {
  const TempFolder folder;
  Image image = test_image(5, 4);
  image.standard_error.clear();
  image.sample_count.clear();
  write_exr(folder / "a.exr", image);
  const Image back = read_image(folder / "a.exr");
  EXPECT_FALSE(back.has_statistics());
  EXPECT_TRUE(same_bits(back.pixels, image.pixels));
}

TEST(Exr, HasTheChannelsAndAttributesThatAreDocumented) {
  const TempFolder folder;
  write_exr(folder / "a.exr", test_image(5, 4));
  Imf::InputFile file((folder / "a.exr").c_str());
  for (const char* name : {"R", "G", "B", "StdErr.R", "StdErr.G", "StdErr.B"}) {
    const Imf::Channel* channel = file.header().channels().findChannel(name);
    ASSERT_NE(channel, nullptr) << name;
    EXPECT_EQ(channel->type, Imf::FLOAT) << name;
  }
  ASSERT_NE(file.header().channels().findChannel("SampleCount"), nullptr);
  EXPECT_EQ(file.header().channels().findChannel("SampleCount")->type, Imf::UINT);
  EXPECT_NE(file.header().find("chromaticities"), file.header().end());
  EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("scene").value(), "a box.xml");
  // "version" is an integer of the format's own: a text of that name would make newer libraries refuse the file.
  EXPECT_EQ(file.header().find("version"), file.header().end());
  EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("etendue.version").value(), "1.2.3");
}

TEST(Exr, RefusesImagesThatDoNotFitTogether) {
  const TempFolder folder;
  for (int i = 0; i < 4; ++i) {
    Image image = test_image(5, 4);
    if (i == 0) image.pixels.pop_back();
    if (i == 1) image.standard_error.pop_back();
    if (i == 2) image.sample_count.pop_back();
    if (i == 3) image = Image{};
    error_of([&] { write_exr(folder / "a.exr", image); });
  }
  Image image = test_image(5, 4);
  image.metadata[""] = "x";
  error_of([&] { write_exr(folder / "a.exr", image); });
  image.metadata.erase("");
  image.metadata[std::string(300, 'k')] = "x";
  error_of([&] { write_exr(folder / "a.exr", image); });
  EXPECT_EQ(folder.files(), 0u);
}

TEST(Exr, ReadsHalfFloatsWithAMovedDataWindow) {
  const TempFolder folder;
  const Imath::Box2i window(Imath::V2i(-3, 10), Imath::V2i(4, 14));
  Imf::Header header(Imath::Box2i(Imath::V2i(0, 0), Imath::V2i(99, 99)), window);
  header.compression() = Imf::PIZ_COMPRESSION;
  write_foreign(folder / "a.exr", header,
                {{"R", Imf::Channel(Imf::HALF)},
                 {"G", Imf::Channel(Imf::HALF)},
                 {"B", Imf::Channel(Imf::FLOAT)},
                 {"A", Imf::Channel(Imf::HALF)},
                 {"StdErr.R", Imf::Channel(Imf::FLOAT)}});
  const Image image = read_image(folder / "a.exr");
  EXPECT_EQ(image.width, 8u);
  EXPECT_EQ(image.height, 5u);
  EXPECT_EQ(image.pixels[0], glm::vec3(0, 1, 2));
  EXPECT_EQ(image.pixels[8 * 3 + 2], glm::vec3(203, 204, 205));
  EXPECT_TRUE(image.standard_error.empty()) << "one of three standard errors is none";
}

TEST(Exr, ReadsGreyAsThreeEqualChannels) {
  const TempFolder folder;
  write_foreign(folder / "a.exr", Imf::Header(3, 2), {{"Y", Imf::Channel(Imf::FLOAT)}});
  const Image image = read_image(folder / "a.exr");
  EXPECT_EQ(image.pixels[5], glm::vec3(201));
}

TEST(Exr, RefusesPicturesItWouldMisread) {
  const TempFolder folder;
  const Imf::Channel full(Imf::FLOAT), integer(Imf::UINT), coarse(Imf::FLOAT, 2, 2);
  const auto sentence = [&](const std::vector<std::pair<std::string, Imf::Channel>>& channels) {
    write_foreign(folder / "a.exr", Imf::Header(4, 4), channels);
    return error_of([&] { read_image(folder / "a.exr"); });
  };
  EXPECT_NE(sentence({{"R", full}, {"G", full}}).find("R, G and B"), std::string::npos);
  EXPECT_NE(sentence({{"R", full}, {"G", integer}, {"B", full}}).find("channel G"), std::string::npos);
  EXPECT_NE(sentence({{"R", full}, {"G", full}, {"B", coarse}}).find("channel B"), std::string::npos);
}

TEST(Exr, RefusesSeveralParts) {
  const TempFolder folder;
  std::vector<Imf::Header> headers(2, Imf::Header(4, 4));
  for (std::size_t i = 0; i < 2; ++i) {
    headers[i].setName(i == 0 ? "a" : "b");
    headers[i].setType(Imf::SCANLINEIMAGE);
    headers[i].channels().insert("R", Imf::Channel(Imf::FLOAT));
  }
  {
    Imf::MultiPartOutputFile file((folder / "a.exr").c_str(), headers.data(), 2);
    const std::vector<float> values(16, 1.0f);
    for (int part = 0; part < 2; ++part) {
      Imf::FrameBuffer buffer;
      buffer.insert("R", Imf::Slice::Make(Imf::FLOAT, values.data(), headers[0].dataWindow()));
      Imf::OutputPart output(file, part);
      output.setFrameBuffer(buffer);
      output.writePixels(4);
    }
  }
  EXPECT_NE(error_of([&] { read_image(folder / "a.exr"); }).find("several parts"), std::string::npos);
}

TEST(Exr, RefusesEveryTruncation) {
  const TempFolder folder;
  write_exr(folder / "a.exr", test_image(19, 40));
  const std::string whole = slurp(folder / "a.exr");
  for (std::size_t length = 0; length < whole.size(); length += length < 700 ? 7 : 97) {
    spill(folder / "b.exr", whole.substr(0, length));
    const std::string sentence = error_of([&] { read_image(folder / "b.exr"); });
    EXPECT_EQ(sentence.find(folder / "b.exr"), 0u) << sentence;
  }
  spill(folder / "b.exr", whole.substr(0, whole.size() - 1));
  error_of([&] { read_image(folder / "b.exr"); });
}

TEST(Exr, SurvivesAnyChangedByte) {
  const TempFolder folder;
  Image image = test_image(9, 21);
  image.metadata.erase("aVeryLongNameThatNeedsTheLongNamesFlagOfTheFormat");
  write_exr(folder / "a.exr", image);
  const std::string whole = slurp(folder / "a.exr");
  int refused = 0;
  for (std::size_t i = 0; i < whole.size(); i += i < 1200 ? 1 : 13) {
    for (const char value : {'\x00', '\xff', '\x7f', static_cast<char>(whole[i] ^ 1)}) {
      std::string bytes = whole;
      bytes[i] = value;
      spill(folder / "b.exr", bytes);
      try {
        const Image back = read_image(folder / "b.exr");
        EXPECT_EQ(back.pixels.size(), std::size_t{back.width} * back.height);
      } catch (const Error& error) {
        EXPECT_EQ(static_cast<int>(error.kind()), static_cast<int>(ErrorKind::file));
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 1000) << "hardly anything was refused: is the file read at all?";
}

TEST(Exr, RefusesSizesBeyondReasonBeforeAllocating) {
  const TempFolder folder;
  write_exr(folder / "a.exr", test_image(4, 4));
  std::string bytes = slurp(folder / "a.exr");
  const std::size_t at = bytes.find("dataWindow") + 11 + 6 + 4;  // after the name, the type "box2i" and the size
  const auto with_maximum = [&](std::uint32_t x, std::uint32_t y) {
    std::string changed = bytes;
    std::memcpy(changed.data() + at + 8, &x, 4);
    std::memcpy(changed.data() + at + 12, &y, 4);
    spill(folder / "b.exr", changed);
    return error_of([&] { read_image(folder / "b.exr"); });
  };
  EXPECT_NE(with_maximum(99999, 9).find("100000x10"), std::string::npos);
  EXPECT_NE(with_maximum(29999, 29999).find("30000x30000"), std::string::npos);
  EXPECT_NE(with_maximum(7999, 7999).find("bytes"), std::string::npos);
  with_maximum(0x7fffffff, 0x7fffffff);
  with_maximum(0xffffffff, 0xffffffff);
}

TEST(ReadImage, GoesByContentNotByName) {
  const TempFolder folder;
  write_exr(folder / "picture.png", test_image(4, 4));
  EXPECT_EQ(read_image(folder / "picture.png").width, 4u);
  spill(folder / "text.exr", "not a picture");
  EXPECT_NE(error_of([&] { read_image(folder / "text.exr"); }).find("neither an EXR nor a PNG"), std::string::npos);
  spill(folder / "empty.exr", "");
  error_of([&] { read_image(folder / "empty.exr"); });
  error_of([&] { read_image(folder / "missing.exr"); });
}

}  // namespace
}  // namespace etendue
