#pragma once
/// Members of glTF objects by type: what is missing has a default, what is of the wrong type is an error.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "core/errors.h"
#include "formats/gltf/json_tree.h"

namespace etendue {

/// What is wrong with a value of the document. `message` is a sentence without a full stop.
struct GltfError {
  const JsonValue* where = nullptr;
  std::string message;
  ErrorKind kind = ErrorKind::scene;
};

// Of an object, by name. Each throws GltfError for a value of another type.
double number_or(const JsonValue& object, std::string_view name, double otherwise);
bool bool_or(const JsonValue& object, std::string_view name, bool otherwise);
std::string string_or(const JsonValue& object, std::string_view name, const std::string& otherwise);
/// A whole number from 0 to 2^53.
std::optional<std::uint64_t> find_count(const JsonValue& object, std::string_view name);
std::uint64_t count_or(const JsonValue& object, std::string_view name, std::uint64_t otherwise);
/// The same as an index; what it refers to is up to the caller.
std::optional<std::uint32_t> find_index(const JsonValue& object, std::string_view name);
std::optional<std::vector<double>> find_numbers(const JsonValue& object, std::string_view name);
std::optional<std::vector<double>> find_numbers(const JsonValue& object, std::string_view name, std::size_t count);
glm::dvec2 vec2_or(const JsonValue& object, std::string_view name, const glm::dvec2& otherwise);
glm::dvec3 vec3_or(const JsonValue& object, std::string_view name, const glm::dvec3& otherwise);
glm::dvec4 vec4_or(const JsonValue& object, std::string_view name, const glm::dvec4& otherwise);
std::vector<std::uint32_t> indices_of(const JsonValue& object, std::string_view name);
std::vector<std::string> strings_of(const JsonValue& object, std::string_view name);

/// The elements of a member that is an array; none where it is missing.
const JsonValue::Array& array_of(const JsonValue& object, std::string_view name);
/// A member that is an object; nullptr where it is missing.
const JsonValue* find_object(const JsonValue& object, std::string_view name);
const JsonValue* find_extension(const JsonValue& object, std::string_view name);

}  // namespace etendue
