#include "formats/gltf/gltf_values.h"

#include <cmath>

#include <fmt/format.h>

namespace etendue {
namespace {

constexpr double kMostCount = 9007199254740992.0;  // 2^53

[[noreturn]] void refuse(const JsonValue& value, std::string_view name, const char* wanted) {
  throw GltfError{&value, fmt::format("\"{}\" is {}; it must be {}", name, value.kind(), wanted)};
}

double number(const JsonValue& value, std::string_view name) {
  if (const double* n = value.number(); n != nullptr) return *n;
  refuse(value, name, "a number");
}

std::uint64_t count(const JsonValue& value, std::string_view name) {
  const double n = number(value, name);
  if (!(n >= 0.0 && n <= kMostCount) || n != std::floor(n))
    throw GltfError{&value, fmt::format("\"{}\" is {}; it must be a non-negative whole number", name, n)};
  return static_cast<std::uint64_t>(n);
}

std::uint32_t index(const JsonValue& value, std::string_view name) {
  const std::uint64_t n = count(value, name);
  if (n > 0xfffffffeu) throw GltfError{&value, fmt::format("\"{}\" is {}, too large for an index", name, n)};
  return static_cast<std::uint32_t>(n);
}

}  // namespace

double number_or(const JsonValue& object, std::string_view name, double otherwise) {
  const JsonValue* value = object.find(name);
  return value == nullptr ? otherwise : number(*value, name);
}

bool bool_or(const JsonValue& object, std::string_view name, bool otherwise) {
  const JsonValue* value = object.find(name);
  if (value == nullptr) return otherwise;
  if (value->boolean() == nullptr) refuse(*value, name, "true or false");
  return *value->boolean();
}

std::string string_or(const JsonValue& object, std::string_view name, const std::string& otherwise) {
  const JsonValue* value = object.find(name);
  if (value == nullptr) return otherwise;
  if (value->string() == nullptr) refuse(*value, name, "a string");
  return *value->string();
}

std::optional<std::uint64_t> find_count(const JsonValue& object, std::string_view name) {
  const JsonValue* value = object.find(name);
  return value == nullptr ? std::nullopt : std::optional(count(*value, name));
}

std::uint64_t count_or(const JsonValue& object, std::string_view name, std::uint64_t otherwise) {
  return find_count(object, name).value_or(otherwise);
}

std::optional<std::uint32_t> find_index(const JsonValue& object, std::string_view name) {
  const JsonValue* value = object.find(name);
  return value == nullptr ? std::nullopt : std::optional(index(*value, name));
}

std::optional<std::vector<double>> find_numbers(const JsonValue& object, std::string_view name) {
  const JsonValue* value = object.find(name);
  if (value == nullptr) return std::nullopt;
  if (value->array() == nullptr) refuse(*value, name, "an array of numbers");
  std::vector<double> numbers;
  for (const JsonValue& element : *value->array()) numbers.push_back(number(element, name));
  return numbers;
}

std::optional<std::vector<double>> find_numbers(const JsonValue& object, std::string_view name, std::size_t count) {
  std::optional<std::vector<double>> numbers = find_numbers(object, name);
  if (numbers && numbers->size() != count)
    throw GltfError{object.find(name),
                    fmt::format("\"{}\" has {} numbers; it must have {}", name, numbers->size(), count)};
  return numbers;
}

glm::dvec2 vec2_or(const JsonValue& object, std::string_view name, const glm::dvec2& otherwise) {
  const auto n = find_numbers(object, name, 2);
  return n ? glm::dvec2((*n)[0], (*n)[1]) : otherwise;
}

glm::dvec3 vec3_or(const JsonValue& object, std::string_view name, const glm::dvec3& otherwise) {
  const auto n = find_numbers(object, name, 3);
  return n ? glm::dvec3((*n)[0], (*n)[1], (*n)[2]) : otherwise;
}

glm::dvec4 vec4_or(const JsonValue& object, std::string_view name, const glm::dvec4& otherwise) {
  const auto n = find_numbers(object, name, 4);
  return n ? glm::dvec4((*n)[0], (*n)[1], (*n)[2], (*n)[3]) : otherwise;
}

std::vector<std::uint32_t> indices_of(const JsonValue& object, std::string_view name) {
  std::vector<std::uint32_t> indices;
  for (const JsonValue& element : array_of(object, name)) indices.push_back(index(element, name));
  return indices;
}

std::vector<std::string> strings_of(const JsonValue& object, std::string_view name) {
  std::vector<std::string> strings;
  for (const JsonValue& element : array_of(object, name)) {
    if (element.string() == nullptr) refuse(element, name, "an array of strings");
    strings.push_back(*element.string());
  }
  return strings;
}

const JsonValue::Array& array_of(const JsonValue& object, std::string_view name) {
  static const JsonValue::Array kNone;
  const JsonValue* value = object.find(name);
  if (value == nullptr) return kNone;
  if (value->array() == nullptr) refuse(*value, name, "an array");
  return *value->array();
}

const JsonValue* find_object(const JsonValue& object, std::string_view name) {
  const JsonValue* value = object.find(name);
  if (value != nullptr && value->object() == nullptr) refuse(*value, name, "an object");
  return value;
}

const JsonValue* find_extension(const JsonValue& object, std::string_view name) {
  const JsonValue* extensions = find_object(object, "extensions");
  return extensions == nullptr ? nullptr : find_object(*extensions, name);
}

}  // namespace etendue
