#pragma once
/// Materials → records for a device, and the textures that their floats are multiplied with.

#include <vector>

#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// What a record needs beside itself is added to `tables`, see kTransmittanceNodes.
gpu::MaterialRecord material_record(const Material& material, std::vector<gpu::vec4>& tables);

/// Adds the uses of textures by a material; of an adapter only its first parameter has one.
gpu::MaterialTextures material_textures(const Material& material, std::vector<gpu::TextureUse>& uses);

}  // namespace etendue
