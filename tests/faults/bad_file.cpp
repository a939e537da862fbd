/// Pictures and films that are damaged or lie, and command lines that ask for what cannot be.

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "bad_inputs.h"

namespace etendue::faults {
namespace {

namespace fs = std::filesystem;

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 0xff);
  return bytes;
}
std::string little_endian(std::uint32_t value) {
  std::string bytes = big_endian(value);
  std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// The checksum of PNG chunks (ISO 3309).
std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffu;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  return ~crc;
}
std::string chunk(const std::string& type, const std::string& data) {
  return big_endian(static_cast<std::uint32_t>(data.size())) + type + data + big_endian(crc32(type + data));
}
/// A PNG file of some size with these bytes for its compressed pixels.
std::string png(std::uint32_t width, std::uint32_t height, const std::string& data, char depth = 8, char color = 2,
                char interlace = 0) {
  const std::string header = big_endian(width) + big_endian(height) + std::string{depth, color, 0, 0, interlace};
  return "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) + chunk("IDAT", data) + chunk("IEND", "");
}

/// A picture and a film as the program writes them, made once.
class BadFile : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const fs::path folder = fs::temp_directory_path() / ("etendue-good-" + std::to_string(getpid()));
    fs::create_directories(folder);
    const std::string scene = SCENES_DIR "/cbox-sphere.xml";
    const std::vector<std::string> common = {"render", scene,   "--device", "reference", "--size",
                                             "8x6",    "--spp", "2",        "-q"};
    auto arguments = common;
    arguments.insert(arguments.end(), {"-o", "p.exr", "-o", "p.png"});
    const ProcessResult pictures = etendue(arguments, folder);
    arguments = common;
    arguments.insert(arguments.end(), {"--film", "-o", "f.exr"});
    const ProcessResult films = etendue(arguments, folder);
    exr_ = read_text(folder / "p.exr");
    png_ = read_text(folder / "p.png");
    film_ = read_text(folder / "f.exr");
    fs::remove_all(folder);
    ASSERT_TRUE(pictures.code == 0 && films.code == 0) << pictures.err << films.err;
  }

  /// Both commands that read pictures or films end with code 6 and name the file.
  static void expect_bad_picture(const std::string& name, const std::string& bytes, const std::string& file,
                                 const std::string& words = "") {
    expect_refused({"compare: " + name,
                    {file, bytes, "good.exr", exr_},
                    {"compare", file, "good.exr", "--json=r.json"},
                    6,
                    file,
                    words,
                    {}});
  }
  static void expect_bad_film(const std::string& name, const std::string& bytes, const std::string& words = "") {
    const std::vector<std::string> files = {"film.exr", bytes, "scene.xml", scene_with("")};
    expect_refused({"merge: " + name, files, {"merge", "film.exr", "-o", "out.exr"}, 6, R"(film\.exr)", words, {}});
    expect_refused({"resume: " + name,
                    files,
                    {"render", "scene.xml", "--resume", "film.exr", "-o", "out.exr"},
                    6,
                    R"(film\.exr)",
                    words,
                    {}});
  }
  /// `bytes` with an attribute's value, found by name and type, replaced.
  static std::string with_attribute(std::string bytes, const std::string& name, const std::string& type,
                                    const std::string& value) {
    const std::string head = name + '\0' + type + '\0';
    const std::size_t at = bytes.find(head);
    EXPECT_NE(at, std::string::npos) << name;
    return bytes.replace(at + head.size() + 4, value.size(), value);
  }
  static std::string fmt_window(const std::array<std::uint32_t, 4>& corners) {
    std::string text = "window";
    for (const std::uint32_t c : corners) text.append(" ").append(std::to_string(static_cast<std::int32_t>(c)));
    return text;
  }
  static std::string box(std::array<std::uint32_t, 4> corners) {
    std::string bytes;
    for (const std::uint32_t c : corners) bytes += little_endian(c);
    return bytes;
  }

  static std::string exr_, png_, film_;
};
std::string BadFile::exr_, BadFile::png_, BadFile::film_;

TEST_F(BadFile, Truncations) {
  for (int part = 0; part < 12; ++part) {
    const auto cut = [&](const std::string& whole) { return whole.substr(0, whole.size() * part / 12); };
    expect_bad_picture("part " + std::to_string(part), cut(exr_), "bad.exr");
    expect_bad_picture("part " + std::to_string(part), cut(png_), "bad.png");
    expect_bad_film("part " + std::to_string(part), cut(film_));
  }
  expect_bad_picture("last byte", exr_.substr(0, exr_.size() - 1), "bad.exr");
  expect_bad_picture("last chunk", png_.substr(0, png_.size() - 12), "bad.png");
  expect_bad_film("last byte", film_.substr(0, film_.size() - 1), "truncated or was changed");
}

TEST_F(BadFile, OtherThings) {
  const std::vector<std::string> things = {"",
                                           "\n",
                                           "hello",
                                           scene_with(""),
                                           std::string(100000, '\0'),
                                           "\x89PNG\r\n\x1a\n",
                                           "\x76\x2f\x31\x01",
                                           std::string("\x76\x2f\x31\x01\x02\0\0\0", 8),
                                           std::string("\x76\x2f\x31\x01\x02\x08\0\0", 8),
                                           std::string("\x76\x2f\x31\x01\x02\x10\0\0", 8),
                                           std::string("\x76\x2f\x31\x01\x09\0\0\0", 8) + exr_.substr(8),
                                           "\x1f\x8b\x08" + exr_,
                                           "#?RADIANCE\n",
                                           "GIF89a",
                                           std::string("\xff\xd8\xff\xe0", 4)};
  for (std::size_t i = 0; i < things.size(); ++i) {
    expect_bad_picture("thing " + std::to_string(i), things[i], "bad.exr");
    expect_bad_picture("thing " + std::to_string(i), things[i], "bad.png");
    expect_bad_film("thing " + std::to_string(i), things[i]);
  }
  expect_bad_film("a picture", exr_, "holds no film");
  expect_bad_film("a PNG", png_, "not an EXR file");
}

TEST_F(BadFile, HeadersThatLie) {
  const std::uint32_t most = 0x7fffffffu, least = 0x80000000u, minus = 0xffffffffu;
  const std::vector<std::array<std::uint32_t, 4>> windows = {
      {0, 0, most, most}, {least, least, most, most}, {0, 0, minus, minus},     {5, 5, 0, 0},
      {0, 0, 65536, 0},   {0, 0, 65535, 65535},       {most, most, most, most}, {0, 0, 7, most},
      {0, 0, 4000, 4000}, {least, 0, least, 5},       {0, 0, 20000, 100}};
  for (const auto& window : windows) {
    const std::string name = fmt_window(window);
    expect_bad_picture(name, with_attribute(exr_, "dataWindow", "box2i", box(window)), "bad.exr");
    expect_bad_film(name, with_attribute(film_, "dataWindow", "box2i", box(window)));
  }
  expect_bad_picture("compression 77", with_attribute(exr_, "compression", "compression", "\x4d"), "bad.exr");
  expect_bad_picture("line order 9", with_attribute(exr_, "lineOrder", "lineOrder", "\x09"), "bad.exr");
  expect_bad_picture("pixel type", with_attribute(exr_, "channels", "chlist", std::string("B\0\x63\0\0\0", 6)),
                     "bad.exr");
  const std::size_t size_at = exr_.find(std::string("chlist\0", 7)) + 7;
  expect_bad_picture("attribute of 2 GiB", std::string(exr_).replace(size_at, 4, little_endian(most)), "bad.exr");
  expect_bad_picture("attribute of -1 byte", std::string(exr_).replace(size_at, 4, little_endian(minus)), "bad.exr");
  expect_bad_film("exponent", with_attribute(film_, "filmExponent", "int", little_endian(most)));
  expect_bad_film("format", with_attribute(film_, "filmFormat", "int", little_endian(3)));
}

TEST_F(BadFile, EveryTenthByteOfAFilmGuarded) {
  for (std::size_t at = 4; at < film_.size(); at += film_.size() / 24) {
    std::string bytes = film_;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x11);
    expect_bad_film("byte " + std::to_string(at), bytes);
    expect_bad_picture("byte " + std::to_string(at) + " of a film", bytes, "bad.exr");
  }
}

TEST_F(BadFile, PngsThatLie) {
  const std::vector<std::pair<std::string, std::string>> pictures = {
      {"0 x 0", png(0, 0, "")},
      {"0 wide", png(0, 5, "x")},
      {"2^31 wide", png(0x80000000u, 1, "x")},
      {"2^31 - 1 square", png(0x7fffffffu, 0x7fffffffu, "x")},
      {"65537 wide", png(65537, 1, "x")},
      {"65536 square", png(65536, 65536, std::string(100, 'x'))},
      {"announces 12 MB in 3 bytes", png(2000, 2000, "abc")},
      {"no pixels", png(8, 6, "")},
      {"noise for pixels", png(8, 6, std::string(200, '\xa5'))},
      {"depth 3", png(8, 6, "x", 3)},
      {"color 5", png(8, 6, "x", 8, 5)},
      {"palette missing", png(8, 6, "x", 8, 3)},
      {"interlace 7", png(8, 6, "x", 8, 2, 7)},
      {"no IHDR", "\x89PNG\r\n\x1a\n" + chunk("IDAT", "x") + chunk("IEND", "")},
      {"two IHDR", png_.substr(0, 33) + png_.substr(8)},
      {"critical chunk unknown", png_.substr(0, 33) + chunk("ABCD", "x") + png_.substr(33)},
      {"chunk of 2 GiB", png_.substr(0, 33) + big_endian(0x7fffffffu) + "IDAT"},
      {"text of 1.7 GiB", png_.substr(0, 33) + big_endian(0x6800000bu) + "iTXtscene" + png_.substr(33)},
      {"chunk of 4 GiB", png_.substr(0, 33) + big_endian(0xffffffffu) + "IDAT" + png_.substr(41)}};
  for (const auto& [name, bytes] : pictures) expect_bad_picture(name, bytes, "bad.png");
  for (std::size_t at = 8; at < std::min<std::size_t>(png_.size(), 400); at += 13) {
    std::string bytes = png_;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x20);  // the checksum of its chunk no longer fits
    expect_bad_picture("byte " + std::to_string(at), bytes, "bad.png");
  }
}

// A few kilobytes can unpack to gigabytes: what cannot be compared is not unpacked.
TEST_F(BadFile, PicturesOfOtherSizesAreNotUnpacked) {
  const std::string bomb = png(8192, 8192, std::string(10000, 'x'), 1, 0);  // never looked into
  for (const auto& files : {std::pair{"bomb.png", "good.exr"}, std::pair{"good.exr", "bomb.png"}}) {
    expect_refused({"bomb",
                    {"bomb.png", bomb, "good.exr", exr_},
                    {"compare", files.first, files.second},
                    2,
                    "the pictures differ in size",
                    "8192×8192",
                    {}});
  }
}

TEST_F(BadFile, NoFiles) {
  const std::vector<std::pair<std::string, std::function<void(const fs::path&)>>> things = {
      {"nothing", [](const fs::path&) {}},
      {"folder", [](const fs::path& p) { fs::create_directory(p); }},
      {"fifo", [](const fs::path& p) { ASSERT_EQ(mkfifo(p.c_str(), 0600), 0); }},
      {"link to itself", [](const fs::path& p) { fs::create_symlink(p.filename(), p); }},
      {"device", [](const fs::path& p) { fs::create_symlink("/dev/zero", p); }}};
  for (const auto& [name, make] : things) {
    const auto prepare = [&make = make](const fs::path& folder) { make(folder / "bad.exr"); };
    expect_refused(
        {"compare " + name, {"good.exr", exr_}, {"compare", "good.exr", "bad.exr"}, 6, R"(bad\.exr: )", "", prepare});
    expect_refused({"merge " + name, {}, {"merge", "bad.exr", "-o", "out.exr"}, 6, R"(bad\.exr: )", "", prepare});
    expect_refused({"resume " + name,
                    {"scene.xml", scene_with("")},
                    {"render", "scene.xml", "--resume", "bad.exr", "-o", "out.exr"},
                    6,
                    R"(bad\.exr: )",
                    "",
                    prepare});
  }
}

}  // namespace
}  // namespace etendue::faults
