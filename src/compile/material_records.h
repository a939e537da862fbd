#pragma once
/// Converts materials to records for a device, with the textures that multiply their floats.

#include <vector>

#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// Additional tables that a record needs are appended to `tables`, see kTransmittanceNodes.
gpu::MaterialRecord material_record(const Material& material, std::vector<gpu::vec4>& tables);

/// Appends the texture uses of a material. In an adapter, only the first parameter can have a texture.
gpu::MaterialTextures material_textures(const Material& material, std::vector<gpu::TextureUse>& uses);

}  // namespace etendue
