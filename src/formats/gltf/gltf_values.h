#pragma once
/// Reads members of glTF objects by type. A missing member has a default; one of the wrong type is an error.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "core/errors.h"
#include "formats/gltf/json_tree.h"

namespace etendue {

/// An error in the document, at a value. `message` is a sentence without a full stop.
struct GltfError {
  const JsonValue* where = nullptr;
  std::string message;
  ErrorKind kind = ErrorKind::scene;
};

// Members of an object by name. All functions throw GltfError for a value of another type.
double number_or(const JsonValue& object, std::string_view name, double otherwise);
bool bool_or(const JsonValue& object, std::string_view name, bool otherwise);
std::string string_or(const JsonValue& object, std::string_view name, const std::string& otherwise);
/// An integer from 0 to 2^53.
std::optional<std::uint64_t> find_count(const JsonValue& object, std::string_view name);
std::uint64_t count_or(const JsonValue& object, std::string_view name, std::uint64_t otherwise);
/// The same for an index; the caller must check that it refers to something.
std::optional<std::uint32_t> find_index(const JsonValue& object, std::string_view name);
std::optional<std::vector<double>> find_numbers(const JsonValue& object, std::string_view name);
std::optional<std::vector<double>> find_numbers(const JsonValue& object, std::string_view name, std::size_t count);
glm::dvec2 vec2_or(const JsonValue& object, std::string_view name, const glm::dvec2& otherwise);
glm::dvec3 vec3_or(const JsonValue& object, std::string_view name, const glm::dvec3& otherwise);
glm::dvec4 vec4_or(const JsonValue& object, std::string_view name, const glm::dvec4& otherwise);
std::vector<std::uint32_t> indices_of(const JsonValue& object, std::string_view name);
std::vector<std::string> strings_of(const JsonValue& object, std::string_view name);

/// The elements of a member that is an array; empty if it is missing.
const JsonValue::Array& array_of(const JsonValue& object, std::string_view name);
/// A member that is an object; nullptr if it is missing.
const JsonValue* find_object(const JsonValue& object, std::string_view name);
const JsonValue* find_extension(const JsonValue& object, std::string_view name);

}  // namespace etendue
