#pragma once
/// Decodes buffer views that are compressed with EXT_meshopt_compression.

#include <cstddef>
#include <span>
#include <vector>

#include "formats/gltf/gltf_values.h"

namespace etendue {

/// Throws GltfError, also for a damaged stream.
std::vector<std::byte> decode_meshopt(const JsonValue& extension, std::span<const std::byte> stream);

}  // namespace etendue
