#pragma once
/// Primitives compressed by KHR_draco_mesh_compression.

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
  std::map<std::string, FloatTable> attributes;  ///< by the names of the primitive's attributes
};

/// `extension` is that of the primitive. Throws GltfError, also where the stream is damaged.
DracoMesh decode_draco(const JsonValue& extension, std::span<const std::byte> stream);

}  // namespace etendue
