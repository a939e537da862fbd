#pragma once
/// What the members of glTF's objects may be: a table of the JSON schemas of the standard and of the extensions that
/// are read.

#include <functional>
#include <string>

#include "formats/gltf/json_tree.h"

namespace etendue {

/// Reports a sentence about a value.
using GltfComplaint = std::function<void(const JsonValue& where, const std::string& sentence)>;

/// Checks a whole document: unknown, missing, empty and repeated members, types, ranges and indices.
void check_gltf_schema(const JsonValue& root, const GltfComplaint& complain);

}  // namespace etendue
