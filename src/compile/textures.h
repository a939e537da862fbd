#pragma once
/// Textures → tables for a device.

#include <cstdint>
#include <memory>
#include <vector>

#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// What shaders/texture.glsl reads. All of it is empty for a scene whose surfaces and lamps have no textures.
struct CompiledTextures {
  std::uint32_t features = 0;  ///< kTextures*: what kernels are built for
  std::vector<gpu::TextureRecord> textures;
  std::vector<gpu::InstanceAttributes> instances;
  std::vector<gpu::vec4> attributes;
  /// Their texels lie one behind the other, each from a multiple of 16 bytes on, as they are: no copies are made.
  std::vector<std::shared_ptr<const Bitmap>> bitmaps;
};

/// Throws Error(scene) where a picture is too large to be addressed.
CompiledTextures compile_textures(const Scene& scene);

}  // namespace etendue
