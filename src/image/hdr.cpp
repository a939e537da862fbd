/// Radiance HDR pictures [Ward1991]: a shared exponent of 8 bits for three mantissas of 8 bits.
///
/// A mantissa m with exponent e stands for m · 2^(e − 136), as in most programs, and e = 0 for black. Radiance itself
/// uses m + 1/2, the middle of the truncated interval.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "core/errors.h"
#include "core/printable.h"
#include "core/text.h"
#include "image/decode.h"

namespace etendue {
namespace {

constexpr std::size_t kLongestLine = 4096;  // of a header; a command line in it may be long
constexpr std::size_t kMostLines = 4096;
constexpr std::size_t kMostQuoted = 60;

using Rgbe = std::array<std::uint8_t, 4>;

struct HdrHeader {
  bool xyz = false;
  double exposure = 1;             ///< product of all EXPOSURE lines: pixels are radiance times this
  glm::dvec3 correction{1, 1, 1};  ///< the same for COLORCORR, per channel
  bool primaries = false;
  std::uint64_t lines = 0;  ///< number of scan lines, and pixels in each
  std::uint64_t length = 0;
  bool rows = true;             ///< whether a scan line is a row of the picture or a column
  bool line_backward = false;   ///< scan lines come bottom row (or right column) first
  bool pixel_backward = false;  ///< pixels in a scan line come right (or bottom) first
};

class HdrReader {
 public:
  HdrReader(std::span<const std::byte> bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  HdrHeader header();
  /// Unpacks one scan line into `line`, or skips it if `line` is null.
  void scan_line(std::uint64_t length, std::vector<Rgbe>* line);
  std::size_t position() const { return position_; }
  void go_to(std::size_t position) { position_ = position; }
  [[noreturn]] void fail(const std::string& reason) const {
    throw Error(ErrorKind::file, fmt::format("{}: is a damaged HDR file: {}", path_, reason));
  }

 private:
  std::string_view text_line();
  void variable(std::string_view line, HdrHeader& header);
  void resolution(std::string_view line, HdrHeader& header);
  double positive(std::string_view token, const char* name);
  std::uint8_t byte() {
    if (position_ == bytes_.size()) fail("it ends before its last pixel, so it is truncated");
    return std::to_integer<std::uint8_t>(bytes_[position_++]);
  }
  void planes(std::uint64_t length, std::vector<Rgbe>* line);
  void old_runs(std::uint64_t length, Rgbe first, std::vector<Rgbe>* line);

  std::span<const std::byte> bytes_;
  const std::string& path_;
  std::size_t position_ = 0;
};

std::string_view HdrReader::text_line() {
  const std::size_t begin = position_;
  while (position_ < bytes_.size() && position_ - begin <= kLongestLine) {
    if (bytes_[position_++] == std::byte{'\n'}) {
      const std::string_view line(reinterpret_cast<const char*>(bytes_.data()) + begin, position_ - begin - 1);
      return line.ends_with('\r') ? line.substr(0, line.size() - 1) : line;
    }
  }
  fail(position_ == bytes_.size() ? "it ends inside its header"
                                  : fmt::format("a line of its header has more than {} bytes", kLongestLine));
}

double HdrReader::positive(std::string_view token, const char* name) {
  double value = 0;
  const text::NumberError error = text::parse_double(token, value);
  if (error != text::NumberError::none || !(value > 0))
    fail(fmt::format("{} is {}; expected a number above 0", name,
                     text::quoted(std::string(token.substr(0, kMostQuoted)))));
  return value;
}

void HdrReader::variable(std::string_view line, HdrHeader& header) {
  const auto value_of = [&](std::string_view name) { return text::trim(line.substr(name.size())); };
  if (line.starts_with("FORMAT=")) {
    const std::string_view format = value_of("FORMAT=");
    header.xyz = format == "32-bit_rle_xyze";
    if (!header.xyz && format != "32-bit_rle_rgbe") {
      fail(fmt::format("FORMAT is {}; expected 32-bit_rle_rgbe or 32-bit_rle_xyze",
                       text::quoted(std::string(format.substr(0, kMostQuoted)))));
    }
  } else if (line.starts_with("EXPOSURE=")) {
    header.exposure *= positive(value_of("EXPOSURE="), "EXPOSURE");
  } else if (line.starts_with("COLORCORR=")) {
    std::string_view rest = value_of("COLORCORR=");
    for (int c = 0; c < 3; ++c) {
      const std::size_t end = std::min(rest.find(' '), rest.size());
      header.correction[c] *= positive(rest.substr(0, end), "COLORCORR");
      rest = text::trim(rest.substr(end));
    }
  } else if (line.starts_with("PRIMARIES=")) {
    header.primaries = true;
  }
}

/// `-Y height +X width`: the axis of the scan lines and then that of the pixels in one, each with the direction in
/// which coordinates go, Y upward and X to the right.
void HdrReader::resolution(std::string_view line, HdrHeader& header) {
  std::array<std::string_view, 4> words{};
  std::string_view rest = text::trim(line);
  for (std::string_view& word : words) {
    word = rest.substr(0, rest.find(' '));
    rest = text::trim(rest.substr(word.size()));
  }
  const auto is_axis = [](std::string_view word, char axis) {
    return word.size() == 2 && (word[0] == '+' || word[0] == '-') && word[1] == axis;
  };
  header.rows = is_axis(words[0], 'Y');
  std::int64_t lines = 0, length = 0;
  const bool valid = rest.empty() &&
                     (header.rows ? is_axis(words[2], 'X') : is_axis(words[0], 'X') && is_axis(words[2], 'Y')) &&
                     text::parse_integer(words[1], lines) == text::NumberError::none && lines > 0 &&
                     text::parse_integer(words[3], length) == text::NumberError::none && length > 0;
  if (!valid) {
    fail(fmt::format("its size is {}; expected something like \"-Y 512 +X 1024\"",
                     text::quoted(std::string(line.substr(0, kMostQuoted)))));
  }
  const auto backward = [](std::string_view axis) { return (axis[0] == '+') == (axis[1] == 'Y'); };
  header.line_backward = backward(words[0]);
  header.pixel_backward = backward(words[2]);
  header.lines = static_cast<std::uint64_t>(lines);
  header.length = static_cast<std::uint64_t>(length);
}

HdrHeader HdrReader::header() {
  HdrHeader header;
  if (!text_line().starts_with("#?")) fail("it does not begin with #?RADIANCE");
  for (std::size_t count = 0; count < kMostLines; ++count) {
    const std::string_view line = text_line();
    if (line.empty()) {
      resolution(text_line(), header);
      return header;
    }
    variable(line, header);
  }
  fail(fmt::format("its header has more than {} lines", kMostLines));
}

/// The newer way: after the length, the four bytes of all pixels plane by plane. A count above 128 repeats the next
/// byte count − 128 times, another is followed by as many bytes.
void HdrReader::planes(std::uint64_t length, std::vector<Rgbe>* line) {
  for (std::size_t plane = 0; plane < 4; ++plane) {
    for (std::uint64_t x = 0; x < length;) {
      const unsigned code = byte();
      const bool run = code > 128;
      const unsigned count = run ? code - 128 : code;
      if (count == 0 || count > length - x)
        fail(fmt::format("a run of {} pixels in a line that has {} left", count, length - x));
      std::uint8_t value = run ? byte() : std::uint8_t{0};
      for (unsigned i = 0; i < count; ++i, ++x) {
        if (!run) value = byte();
        if (line != nullptr) (*line)[x][plane] = value;
      }
    }
  }
}

/// The older way: pixels as they are; a pixel (1, 1, 1, n) repeats the one before n times, several of these in a row
/// are digits of base 256, the lowest first.
void HdrReader::old_runs(std::uint64_t length, Rgbe first, std::vector<Rgbe>* line) {
  Rgbe last{};
  unsigned shift = 0;
  Rgbe pixel = first;
  for (std::uint64_t x = 0; x < length;) {
    if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
      const std::uint64_t count = shift < 32 ? std::uint64_t{pixel[3]} << shift : length;
      if (x == 0 || count > length - x)
        fail(fmt::format("a run of {} pixels in a line that has {} left", count, length - x));
      for (std::uint64_t i = 0; i < count; ++i, ++x) {
        if (line != nullptr) (*line)[x] = last;
      }
      shift += 8;
    } else {
      last = pixel;
      if (line != nullptr) (*line)[x] = pixel;
      ++x;
      shift = 0;
    }
    if (x < length) {
      for (std::uint8_t& part : pixel) part = byte();
    }
  }
}

void HdrReader::scan_line(std::uint64_t length, std::vector<Rgbe>* line) {
  Rgbe first{};
  for (std::uint8_t& part : first) part = byte();
  const bool planar = length >= 8 && length < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
  if (!planar) return old_runs(length, first, line);
  const unsigned announced = unsigned{first[2]} << 8 | first[3];
  if (announced != length) fail(fmt::format("a line of {} pixels where the header says {}", announced, length));
  planes(length, line);
}

/// Converts XYZ to RGB as Radiance does, with the primaries of Rec. 709 except for green (0.290, 0.600) and a white of
/// equal energy, so that grey stays grey, and both kinds of file give the same picture.
glm::dmat3 rgb_from_xyz() {
  const auto xyz = [](double x, double y) { return glm::dvec3(x, y, 1 - x - y) / y; };
  const glm::dmat3 primaries(xyz(0.640, 0.330), xyz(0.290, 0.600), xyz(0.150, 0.060));
  const glm::dvec3 luminances = glm::inverse(primaries) * glm::dvec3(1, 1, 1);
  return glm::inverse(
      glm::dmat3(primaries[0] * luminances.x, primaries[1] * luminances.y, primaries[2] * luminances.z));
}

/// Radiance of a pixel as stored, exposure undone.
class PixelDecoder {
 public:
  explicit PixelDecoder(const HdrHeader& header)
      : xyz_(header.xyz), scale_(1.0 / (header.exposure * header.correction)), rgb_from_xyz_(rgb_from_xyz()) {}

  glm::vec3 operator()(const Rgbe& pixel) const {
    if (pixel[3] == 0) return glm::vec3(0);
    const glm::dvec3 mantissas(pixel[0], pixel[1], pixel[2]);
    glm::dvec3 color = mantissas * std::ldexp(1.0, int{pixel[3]} - 136);
    // Colours outside Rec. 709 would be negative light.
    if (xyz_) color = glm::max(rgb_from_xyz_ * color, glm::dvec3(0));
    return glm::vec3(color * scale_);
  }

 private:
  bool xyz_;
  glm::dvec3 scale_;
  glm::dmat3 rgb_from_xyz_;
};

void add_notes(const HdrHeader& header, const std::string& path, Bitmap& bitmap) {
  if (header.exposure != 1)
    bitmap.notes.push_back(fmt::format("{}: pixels are divided by its EXPOSURE of {:g}", path, header.exposure));
  if (header.correction != glm::dvec3(1))
    bitmap.notes.push_back(fmt::format("{}: pixels are divided by its COLORCORR", path));
  if (header.primaries)
    bitmap.notes.push_back(fmt::format("{}: its PRIMARIES are ignored; colours are taken as Rec. 709", path));
}

}  // namespace

bool is_hdr(std::span<const std::byte> bytes) {
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 10));
  return head.starts_with("#?RADIANCE") || head.starts_with("#?RGBE");
}

Bitmap decode_hdr(std::span<const std::byte> bytes, const std::string& path) {
  HdrReader reader(bytes, path);
  const HdrHeader header = reader.header();
  const std::uint64_t width = header.rows ? header.length : header.lines;
  const std::uint64_t height = header.rows ? header.lines : header.length;
  check_picture_size(width, height, path);
  // First without allocating memory, because a short file may announce a large picture.
  const std::size_t pixels = reader.position();
  for (std::uint64_t i = 0; i < header.lines; ++i) reader.scan_line(header.length, nullptr);
  reader.go_to(pixels);

  Bitmap bitmap = make_bitmap(width, height, 3, BitmapFormat::f32);
  add_notes(header, path, bitmap);
  const PixelDecoder decode(header);
  std::vector<Rgbe> line(header.length);
  for (std::uint64_t i = 0; i < header.lines; ++i) {
    reader.scan_line(header.length, &line);
    const std::uint64_t across = header.line_backward ? header.lines - 1 - i : i;
    for (std::uint64_t j = 0; j < header.length; ++j) {
      const std::uint64_t along = header.pixel_backward ? header.length - 1 - j : j;
      const std::uint64_t pixel = header.rows ? across * width + along : along * width + across;
      const glm::vec3 color = decode(line[j]);
      if (!std::isfinite(color.x) || !std::isfinite(color.y) || !std::isfinite(color.z))
        reader.fail("a pixel divided by its EXPOSURE is not finite");
      std::memcpy(bitmap.texels.data() + pixel * sizeof color, &color, sizeof color);
    }
  }
  return bitmap;
}

}  // namespace etendue
