#include "formats/ply/ply_header.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

constexpr std::size_t kMaxLines = 10000;

struct TypeName {
  const char* name;
  PlyType type;
};
constexpr TypeName kTypes[] = {
    {"char", PlyType::int8},      {"uchar", PlyType::uint8},    {"short", PlyType::int16},
    {"ushort", PlyType::uint16},  {"int", PlyType::int32},      {"uint", PlyType::uint32},
    {"float", PlyType::float32},  {"double", PlyType::float64}, {"int8", PlyType::int8},
    {"uint8", PlyType::uint8},    {"int16", PlyType::int16},    {"uint16", PlyType::uint16},
    {"int32", PlyType::int32},    {"uint32", PlyType::uint32},  {"float32", PlyType::float32},
    {"float64", PlyType::float64}};

class HeaderReader {
 public:
  HeaderReader(PlyStream& stream, Diagnostics& diagnostics) : stream_(stream), diagnostics_(diagnostics) {}

  PlyHeader read() {
    line_ = stream_.header_line();
    if (text::is_lfs_pointer(line_)) throw PlyError{stream_.line_position(), text::kLfsPointer};
    if (text::trim(line_) != "ply")
      throw PlyError{stream_.line_position(), "a PLY file begins with a line \"ply\"; this one does not"};
    for (std::size_t lines = 0; read_line(); ++lines) {
      if (lines == kMaxLines) fail(fmt::format("the header has more than {} lines", kMaxLines));
    }
    if (!format_) fail("the header does not give its format; it needs a line like \"format ascii 1.0\"");
    header_.format = *format_;
    stream_.begin_data(header_.format);
    return std::move(header_);
  }

 private:
  /// False at the end of the header.
  bool read_line() {
    line_ = stream_.header_line();
    at_ = 0;
    const std::string_view word = next();
    if (word == "end_header") return false;
    if (word.empty() || word == "comment" || word == "obj_info") return true;
    if (word == "format") {
      read_format();
    } else if (word == "element") {
      read_element();
    } else if (word == "property") {
      read_property();
    } else if (!std::exchange(unknown_, true)) {
      diagnostics_.warning(
          stream_.line_position(begin_ + 1),
          fmt::format("header lines that start with {} are unknown and ignored, here and below", text::quoted(word)));
    }
    return true;
  }

  /// The next word of the line; empty at its end.
  std::string_view next() {
    while (at_ < line_.size() && text::is_blank(line_[at_])) ++at_;
    begin_ = at_;
    while (at_ < line_.size() && !text::is_blank(line_[at_])) ++at_;
    return line_.substr(begin_, at_ - begin_);
  }
  [[noreturn]] void fail(const std::string& message) const {
    throw PlyError{stream_.line_position(begin_ + 1), message};
  }

  void read_format() {
    if (format_) fail("the format is given twice");
    const std::string_view word = next();
    if (word == "ascii") format_ = PlyFormat::ascii;
    if (word == "binary_little_endian") format_ = PlyFormat::little_endian;
    if (word == "binary_big_endian") format_ = PlyFormat::big_endian;
    if (!format_)
      fail(fmt::format("{} is not a format; known are ascii, binary_little_endian and binary_big_endian",
                       text::quoted(word)));
    if (const std::string_view version = next(); version != "1.0")
      fail(fmt::format("the format has version {}; 1.0 is supported", text::quoted(version)));
  }

  void read_element() {
    PlyElement element;
    element.name = next();
    if (element.name.empty()) fail("this element has no name");
    const std::string_view digits = next();
    element.position = stream_.line_position(begin_ + 1);
    std::int64_t count = 0;
    const text::NumberError error = text::parse_integer(digits, count);
    if (error != text::NumberError::none) fail(text::describe(error, digits, "an integer"));
    if (count < 0) fail(fmt::format("there cannot be {} of an element", count));
    element.count = static_cast<std::uint64_t>(count);
    for (const PlyElement& other : header_.elements) {
      if (other.name == element.name) fail(fmt::format("the element {} is given twice", text::quoted(element.name)));
    }
    header_.elements.push_back(std::move(element));
  }

  PlyType read_type() {
    const std::string_view word = next();
    for (const TypeName& row : kTypes) {
      if (word == row.name) return row.type;
    }
    std::vector<std::string> names;
    for (const TypeName& row : kTypes) names.emplace_back(row.name);
    fail(fmt::format("{} is not a type{}; known are {}", text::quoted(word), text::did_you_mean(word, names),
                     text::join(names)));
  }

  void read_property() {
    if (header_.elements.empty()) fail("this property belongs to no element; a line \"element …\" must come before it");
    const std::size_t before = at_;
    std::optional<PlyType> count_type;
    if (next() == "list") {
      count_type = read_type();
      if (!is_integer(*count_type)) fail("a list counts its items by an integer type");
    } else {
      at_ = before;
    }
    const PlyType type = read_type();
    const std::string_view name = next();
    if (name.empty()) fail("this property has no name");
    std::vector<PlyProperty>& properties = header_.elements.back().properties;
    for (const PlyProperty& other : properties) {
      if (other.name == name) fail(fmt::format("the property {} is given twice", text::quoted(name)));
    }
    properties.push_back({std::string(name), type, count_type});
  }

  PlyStream& stream_;
  Diagnostics& diagnostics_;
  PlyHeader header_;
  std::optional<PlyFormat> format_;
  bool unknown_ = false;
  std::string_view line_;
  std::size_t at_ = 0, begin_ = 0;
};

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& p) { return p.count_type.has_value(); });
}

std::size_t PlyElement::least_size() const {
  std::size_t size = 0;
  for (const PlyProperty& p : properties) size += size_of(p.count_type.value_or(p.type));
  return size;
}

PlyHeader read_ply_header(PlyStream& stream, Diagnostics& diagnostics) {
  return HeaderReader(stream, diagnostics).read();
}

}  // namespace etendue
