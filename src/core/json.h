#pragma once
/// Building and writing JSON; nothing here reads it.
/// The library that writes it takes many seconds to compile wherever it is included, so only json.cpp includes it.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace etendue {

/// A JSON value, copied as a whole. `{1, 2}` is an array, `{{"a", 1}, {"b", 2}}` an object: a list of lists that each
/// contain a string and one more value. Members of an object are written in the order of their names.
class Json {
 public:
  using Array = std::vector<Json>;
  using Object = std::map<std::string, Json, std::less<>>;

  /// null
  Json() = default;
  Json(std::nullptr_t) {}
  Json(std::string_view text) : value_(std::string(text)) {}
  Json(std::string text) : value_(std::move(text)) {}
  Json(const char* text) : value_(std::string(text)) {}
  /// Infinities and NaN are written as null, because JSON cannot represent them.
  template <class T>
  requires std::is_arithmetic_v<T> Json(T number) : value_(widest(number)) {}
  /// Vectors, arrays and sets become arrays, maps with strings as keys objects.
  template <class Range>
  requires requires(const Range& range) {
    range.begin() != range.end();
  } &&(!std::is_convertible_v<const Range&, std::string_view>)Json(const Range& range) {
    if constexpr (requires { typename Range::mapped_type; }) {
      value_ = Object(range.begin(), range.end());
    } else {
      value_ = Array(range.begin(), range.end());
    }
  }
  Json(std::initializer_list<Json> list);

  static Json array() { return Json(Value(Array())); }
  static Json object() { return Json(Value(Object())); }

  bool is_null() const { return std::holds_alternative<std::monostate>(value_); }
  bool contains(std::string_view name) const;

  /// The member of that name, null if it is new. A null becomes an object first; throws std::bad_variant_access for
  /// any other value.
  Json& operator[](std::string_view name);
  /// Appends. A null becomes an array first; throws std::bad_variant_access for any other value.
  void push_back(Json element);

  /// The text, UTF-8: one line if `indent` is negative, otherwise one value per line, indented by so many blanks per
  /// level. Bytes that are not UTF-8 become U+FFFD, so the text is valid JSON whatever the names contain. Numbers
  /// survive a round trip exactly.
  std::string dump(int indent = -1) const;

 private:
  using Value = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double, std::string, Array, Object>;
  friend struct JsonWriter;

  explicit Json(Value value) : value_(std::move(value)) {}

  template <class T>
  static auto widest(T number) {
    if constexpr (std::is_same_v<T, bool>) {
      return number;
    } else if constexpr (std::is_floating_point_v<T>) {
      return static_cast<double>(number);
    } else if constexpr (std::is_signed_v<T>) {
      return static_cast<std::int64_t>(number);
    } else {
      return static_cast<std::uint64_t>(number);
    }
  }

  Value value_;
};

}  // namespace etendue
