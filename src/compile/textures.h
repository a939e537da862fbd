#pragma once
/// Converts textures to tables for a device.

#include <cstdint>
#include <memory>
#include <vector>

#include "gpu_types.h"
#include "scene/scene.h"

namespace etendue {

/// The tables read by shaders/texture.glsl. All are empty for a scene whose surfaces and lamps have no textures.
struct CompiledTextures {
  std::uint32_t features = 0;  ///< kTextures*: the features that kernels need
  std::vector<gpu::TextureRecord> textures;
  std::vector<gpu::InstanceAttributes> instances;
  std::vector<gpu::vec4> attributes;
  /// Their texels follow one another unchanged, each picture starting at a multiple of 16 bytes; no copies are made.
  std::vector<std::shared_ptr<const Bitmap>> bitmaps;
};

/// Throws Error(scene) if a picture is too large to be addressed.
CompiledTextures compile_textures(const Scene& scene);

}  // namespace etendue
