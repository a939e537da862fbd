#pragma once
/// JSON from untrusted files, as a tree whose values know their position. The JSON library takes many seconds to
/// compile wherever it is included, so only json_tree.cpp includes it.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace etendue {

class JsonValue {
 public:
  using Array = std::vector<JsonValue>;
  /// In the order of the file. If members have the same name, the last one counts.
  using Object = std::vector<std::pair<std::string, JsonValue>>;

  JsonValue() = default;

  const bool* boolean() const { return std::get_if<bool>(&value_); }
  const double* number() const { return std::get_if<double>(&value_); }
  const std::string* string() const { return std::get_if<std::string>(&value_); }
  const Array* array() const { return std::get_if<Array>(&value_); }
  const Object* object() const { return std::get_if<Object>(&value_); }
  /// A member of an object; nullptr if it does not exist or this is not an object.
  const JsonValue* find(std::string_view name) const;
  /// Byte offset in the text: of the opening bracket for objects and arrays, near the end for other values.
  std::uint64_t offset() const { return offset_; }
  /// Whether a number is written with a decimal point or an exponent.
  bool has_point() const { return has_point_; }
  /// For messages: "an object", "a number".
  const char* kind() const;

 private:
  friend class JsonTreeBuilder;
  std::variant<std::monostate, bool, double, std::string, Array, Object> value_;
  static constexpr std::uint64_t kOffsets = ~std::uint64_t{0} >> 1;
  std::uint64_t offset_ : 63 = 0;
  bool has_point_ : 1 = false;
};

struct JsonLimits {
  static constexpr std::uint32_t kMaxDepth = 100;  ///< nesting of arrays and objects
  static constexpr std::size_t kMaxLines = std::size_t{1} << 24;
  static constexpr std::size_t kMaxValues = std::size_t{1} << 24;  ///< in a text
};

/// An error in a text, and its byte offset.
struct JsonError {
  std::uint64_t offset = 0;
  std::string message;
};

/// Throws JsonError.
JsonValue parse_json(std::string_view text);

/// Where the lines of a text begin.
class LineIndex {
 public:
  /// Indexes at most kMaxLines lines; everything after counts as the last line.
  explicit LineIndex(std::string_view text);
  /// Line and column of an offset, starting at 1.
  std::pair<int, int> place(std::uint64_t offset) const;

 private:
  std::vector<std::uint64_t> starts_;
};

}  // namespace etendue
