#pragma once
/// Decodes primitives that are compressed with KHR_draco_mesh_compression.

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "formats/gltf/accessors.h"

namespace etendue {

struct DracoMesh {
  std::vector<std::uint32_t> indices;
  std::map<std::string, FloatTable> attributes;  ///< by name of the attribute in the primitive
};

/// `extension` is the extension object of the primitive. Throws GltfError, also for a damaged stream.
DracoMesh decode_draco(const JsonValue& extension, std::span<const std::byte> stream);

}  // namespace etendue
