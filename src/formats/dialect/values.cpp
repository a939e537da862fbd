#include "formats/dialect/values.h"

#include <cmath>

#include <fmt/format.h>

#include "core/text.h"

namespace etendue {
namespace {

std::string number(double value) {
  return fmt::format("{}", value);
}

template <typename T>
T parse_scalar(std::string_view text, const Range& range, text::NumberError (*parse)(std::string_view, T&),
               const char* kind) {
  const std::string_view token = text::trim(text);
  const std::size_t offset = token.empty() ? 0 : static_cast<std::size_t>(token.data() - text.data());
  T value{};
  const text::NumberError error = parse(token, value);
  if (error != text::NumberError::none) throw ValueError{offset, text::describe(error, token, kind)};
  if (!range.contains(static_cast<double>(value))) {
    throw ValueError{offset, fmt::format("{} is out of range; allowed is {}", token, range.describe())};
  }
  return value;
}

bool parse_boolean(std::string_view text) {
  const std::string_view token = text::trim(text);
  if (text::equal_ignoring_case(token, "true")) return true;
  if (text::equal_ignoring_case(token, "false")) return false;
  throw ValueError{0, fmt::format("{} is not a boolean; write true or false", text::quoted(token))};
}

void check_range(const ListedNumber& n, const Range& range) {
  if (!range.contains(n.value))
    throw ValueError{n.offset, fmt::format("{} is out of range; allowed is {}", n.value, range.describe())};
}

std::vector<double> parse_list(std::string_view text, const Range& range) {
  std::vector<double> values;
  for (const ListedNumber& n : parse_numbers(text)) {
    check_range(n, range);
    values.push_back(n.value);
  }
  return values;
}

}  // namespace

bool Range::contains(double value) const {
  return (min_excluded ? value > min : value >= min) && (max_excluded ? value < max : value <= max);
}

std::string Range::describe() const {
  const bool has_min = std::isfinite(min), has_max = std::isfinite(max);
  if (has_min && has_max && !min_excluded && !max_excluded) return number(min) + " … " + number(max);
  std::string text;
  if (has_min) text += (min_excluded ? "> " : "≥ ") + number(min);
  if (has_min && has_max) text += ", ";
  if (has_max) text += (max_excluded ? "< " : "≤ ") + number(max);
  return text;
}

std::vector<ListedNumber> parse_numbers(std::string_view text) {
  const auto is_separator = [](char c) { return c == ',' || text::is_blank(c); };
  std::vector<ListedNumber> numbers;
  for (std::size_t i = 0; i < text.size();) {
    if (is_separator(text[i])) {
      ++i;
      continue;
    }
    const std::size_t begin = i;
    while (i < text.size() && !is_separator(text[i])) ++i;
    const std::string_view token = text.substr(begin, i - begin);
    double value = 0;
    const text::NumberError error = text::parse_double(token, value);
    if (error != text::NumberError::none) throw ValueError{begin, text::describe(error, token, "a number")};
    numbers.push_back({value, begin});
  }
  return numbers;
}

namespace {

std::vector<ListedNumber> parse_exactly(std::size_t count, std::string_view text, const Range& range) {
  std::vector<ListedNumber> numbers = parse_numbers(text);
  if (numbers.size() != count) throw ValueError{0, fmt::format("expected {} numbers, found {}", count, numbers.size())};
  for (const ListedNumber& n : numbers) check_range(n, range);
  return numbers;
}

}  // namespace

glm::dvec3 parse_triple(std::string_view text, const Range& range) {
  const std::vector<ListedNumber> numbers = parse_exactly(3, text, range);
  return {numbers[0].value, numbers[1].value, numbers[2].value};
}

glm::dvec3 parse_pair(std::string_view text, const Range& range) {
  const std::vector<ListedNumber> numbers = parse_exactly(2, text, range);
  return {numbers[0].value, numbers[1].value, 0.0};
}

Value parse_value(ParameterType type, const Range& range, std::string_view text) {
  using enum ParameterType;
  switch (type) {
    case boolean:
      return parse_boolean(text);
    case integer:
      return parse_scalar<std::int64_t>(text, range, text::parse_whole_number, "an integer");
    case real:
      return parse_scalar<double>(text, range, text::parse_double, "a number");
    case string:
      return std::string(text);
    case number_list:
      return parse_list(text, range);
    case point:
    case vector:
    case color:
      return parse_triple(text, range);
    case point2:
    case vector2:
      return parse_pair(text, range);
    case transform:
    case object:
      break;
  }
  throw ValueError{0, type == transform ? "a transform has no value; it holds operations" : "an object has no value"};
}

}  // namespace etendue
