#pragma once
/// Views of buffers compressed by EXT_meshopt_compression.

#include <cstddef>
#include <span>
#include <vector>

#include "formats/gltf/gltf_values.h"

namespace etendue {

/// Throws GltfError, also where the stream is damaged.
std::vector<std::byte> decode_meshopt(const JsonValue& extension, std::span<const std::byte> stream);

}  // namespace etendue
