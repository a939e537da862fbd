#pragma once
/// The parts of the audit, and what they share.

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "formats/gltf/accessors.h"
#include "formats/gltf/gltf_schema.h"
#include "formats/gltf/gltf_values.h"

namespace etendue::gltf_audit {

/// A member that is an array; empty if it is missing or something else, which the schema's check reports.
const JsonValue::Array& list(const JsonValue& object, std::string_view name);
std::optional<double> number_in(const JsonValue& object, std::string_view name);
std::string string_in(const JsonValue& object, std::string_view name);
bool is_true(const JsonValue& object, std::string_view name);
/// The member of a member …: "extensions/KHR_materials_ior/ior". nullptr if one of them is missing.
const JsonValue* follow(const JsonValue& object, std::string_view path);
/// The element of one of the root's arrays that the index `name` of `object` refers to; nullptr if there is none.
const JsonValue* element_of(const JsonValue& root, std::string_view array, const JsonValue& object,
                            std::string_view name);
/// The same with the index itself. Attributes are looked up by this: there may be very many, and to find one by its
/// name takes as long as there are others.
const JsonValue* element_at(const JsonValue& root, std::string_view array, const JsonValue& index);
/// The name of an attribute without its number: "TEXCOORD_" for "TEXCOORD_1".
std::string_view kind_of_attribute(std::string_view name);
/// The types that the standard allows for the rows of an attribute, by its kind; empty if the kind is unknown.
std::string_view types_of_attribute(std::string_view kind);

/// Component types; double, as all numbers of the JSON tree.
inline constexpr double kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
                        kFloat = 5126;

/// How the primitives, skins and animations of a document are put together.
void audit_links(const JsonValue& root, const GltfComplaint& complain);
/// Buffers, views, accessors and the numbers in them, pictures. `with_animations` says whether to check all animations,
/// too, because none was read.
void audit_data(GltfDocument& document, Accessors& accessors, bool with_animations, const GltfComplaint& complain);

}  // namespace etendue::gltf_audit
