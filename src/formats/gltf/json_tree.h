#pragma once
/// JSON that a stranger wrote, as a tree whose values know where they stand. The library that reads it takes many
/// seconds to compile wherever it is included, so only json_tree.cpp includes it.

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
  /// In the order of the file; of members of the same name the last counts.
  using Object = std::vector<std::pair<std::string, JsonValue>>;

  JsonValue() = default;

  const bool* boolean() const { return std::get_if<bool>(&value_); }
  const double* number() const { return std::get_if<double>(&value_); }
  const std::string* string() const { return std::get_if<std::string>(&value_); }
  const Array* array() const { return std::get_if<Array>(&value_); }
  const Object* object() const { return std::get_if<Object>(&value_); }
  /// The member of an object; nullptr where there is none, or this is no object.
  const JsonValue* find(std::string_view name) const;
  /// Bytes from the start of the text: of objects and arrays to their bracket, of others to about their end.
  std::uint64_t offset() const { return offset_; }
  /// "an object", "a number", for messages.
  const char* kind() const;

 private:
  friend class JsonTreeBuilder;
  std::variant<std::monostate, bool, double, std::string, Array, Object> value_;
  std::uint64_t offset_ = 0;
};

struct JsonLimits {
  static constexpr std::uint32_t kMaxDepth = 100;  ///< arrays and objects one in the other
  static constexpr std::size_t kMaxLines = std::size_t{1} << 24;
  static constexpr std::size_t kMaxValues = std::size_t{1} << 24;  ///< of a text
};

/// What is wrong with a text, and where.
struct JsonError {
  std::uint64_t offset = 0;
  std::string message;
};

/// Throws JsonError.
JsonValue parse_json(std::string_view text);

/// Where the lines of a text begin.
class LineIndex {
 public:
  /// Of at most kMaxLines; what follows counts as the last.
  explicit LineIndex(std::string_view text);
  /// Line and column of an offset, from 1.
  std::pair<int, int> place(std::uint64_t offset) const;

 private:
  std::vector<std::uint64_t> starts_;
};

}  // namespace etendue
