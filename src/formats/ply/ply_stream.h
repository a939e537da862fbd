#pragma once
/// The bytes of a PLY file: lines of its header, then numbers in one of three forms, in bounded memory.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/byte_source.h"
#include "scene/scene.h"

namespace etendue {

enum class PlyFormat { ascii, little_endian, big_endian };
enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// Bytes of a value in a binary file.
std::size_t size_of(PlyType type);
constexpr bool is_integer(PlyType type) {
  return type != PlyType::float32 && type != PlyType::float64;
}
/// Largest value of an integer type.
double largest_of(PlyType type);

/// Something wrong with the file, and where.
struct PlyError {
  SourcePosition position;
  std::string message;
};

class PlyStream {
 public:
  PlyStream(ByteSource source, std::string file);

  /// Next line of the header, without its end: LF, CR LF or CR. Throws PlyError at the end of the file and where a
  /// line is too long.
  std::string_view header_line();
  /// From now on values are read in this form.
  void begin_data(PlyFormat format);

  /// The next value as a double, which holds all of their numbers exactly.
  double read(PlyType type);
  /// The same for an integer type.
  std::int64_t read_integer(PlyType type) { return static_cast<std::int64_t>(read(type)); }
  /// Passes over values.
  void skip(PlyType type, std::uint64_t count);
  /// The next `size` bytes of a binary file, at most kMaxRun of them; valid until the next call.
  const char* take(std::size_t size);
  /// A value at a place of a binary file.
  double decode(PlyType type, const char* bytes) const;

  bool is_binary() const { return format_ != PlyFormat::ascii; }
  /// Where the value that was read last begins; of a binary file the file alone.
  SourcePosition position() const;
  SourcePosition line_position(std::size_t column = 1) const {
    return {file_, static_cast<int>(line_), static_cast<int>(column)};
  }
  [[noreturn]] void fail(const std::string& message) const;

  static constexpr std::size_t kMaxRun = std::size_t{1} << 16;

 private:
  std::size_t available() const { return end_ - begin_; }
  /// Tries to have `size` bytes at hand, and returns how many there are.
  std::size_t fill(std::size_t size);
  std::string_view token();
  double read_text(PlyType type);
  [[noreturn]] void fail_at_end() const;

  template <typename T>
  T load(const char* bytes) const {
    char reversed[sizeof(T)];
    if (swap_) {
      for (std::size_t i = 0; i < sizeof(T); ++i) reversed[i] = bytes[sizeof(T) - 1 - i];
      bytes = reversed;
    }
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
  }

  ByteSource source_;
  std::string file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  ///< unread bytes of the buffer
  bool at_end_ = false;
  PlyFormat format_ = PlyFormat::ascii;
  bool swap_ = false;
  bool bare_cr_ = false;          ///< lines of the header end with CR alone
  std::uint64_t passed_ = 0;      ///< bytes of the file before those of the buffer
  std::uint64_t line_ = 0;        ///< of what was read last, from 1
  std::uint64_t line_start_ = 0;  ///< byte of the file where that line begins
  std::uint64_t value_at_ = 0;    ///< byte where the value read last begins
  std::string header_line_;
};

inline double PlyStream::decode(PlyType type, const char* bytes) const {
  switch (type) {
    case PlyType::int8:
      return static_cast<std::int8_t>(*bytes);
    case PlyType::uint8:
      return static_cast<std::uint8_t>(*bytes);
    case PlyType::int16:
      return load<std::int16_t>(bytes);
    case PlyType::uint16:
      return load<std::uint16_t>(bytes);
    case PlyType::int32:
      return load<std::int32_t>(bytes);
    case PlyType::uint32:
      return load<std::uint32_t>(bytes);
    case PlyType::float32:
      return load<float>(bytes);
    case PlyType::float64:
      return load<double>(bytes);
  }
  return 0.0;
}

inline const char* PlyStream::take(std::size_t size) {
  if (available() < size && fill(size) < size) fail_at_end();
  const char* bytes = buffer_.data() + begin_;
  value_at_ = passed_ + begin_;
  begin_ += size;
  return bytes;
}

inline double PlyStream::read(PlyType type) {
  return format_ == PlyFormat::ascii ? read_text(type) : decode(type, take(size_of(type)));
}

inline std::size_t size_of(PlyType type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

}  // namespace etendue
