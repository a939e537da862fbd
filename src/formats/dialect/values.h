#pragma once
/// Values of properties: types, allowed ranges, and reading them from text.

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

/// `object` has no value: only an object can stand for it, see Parameter::child. Points and vectors of the plane are
/// read as such with z = 0.
enum class ParameterType {
  boolean,
  integer,
  real,
  string,
  number_list,
  point,
  vector,
  color,
  transform,
  object,
  point2,
  vector2
};

/// Allowed values; applies to every number of a list, point or color.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;
  bool max_excluded = false;

  bool contains(double value) const;
  /// "1 … 65536", "> 0", "> 0, < 180", or "" without bounds.
  std::string describe() const;
};

/// Makers of ranges, for the tables of dialects.
namespace ranges {
inline Range any() {
  return {};
}
inline Range between(double min, double max) {
  return {min, max, false, false};
}
inline Range inside(double min, double max) {
  return {min, max, true, true};
}
inline Range above(double min) {
  return {min, std::numeric_limits<double>::infinity(), true, false};
}
inline Range above_up_to(double min, double max) {
  return {min, max, true, false};
}
inline Range at_least(double min) {
  return {min, std::numeric_limits<double>::infinity(), false, false};
}
}  // namespace ranges

using Value = std::variant<bool, std::int64_t, double, std::string, std::vector<double>, glm::dvec3>;

/// A value that cannot be read: the position in its text, and the reason.
struct ValueError {
  std::size_t offset;
  std::string message;
};

/// Reads a value of any type that has values, and checks the range. Throws ValueError.
Value parse_value(ParameterType type, const Range& range, std::string_view text);
/// Numbers separated by any run of commas and blanks; each with its offset. Throws ValueError.
struct ListedNumber {
  double value;
  std::size_t offset;
};
std::vector<ListedNumber> parse_numbers(std::string_view text);
/// Exactly three numbers. Throws ValueError.
glm::dvec3 parse_triple(std::string_view text, const Range& range = {});
/// Exactly two numbers; z is 0. Throws ValueError.
glm::dvec3 parse_pair(std::string_view text, const Range& range);

}  // namespace etendue
