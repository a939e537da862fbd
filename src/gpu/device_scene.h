#pragma once
/// A compiled scene in device memory, bound for the kernels.

#include <optional>

#include "compile/compiled_scene.h"
#include "gpu/device_limits.h"
#include "vulkan/commands.h"
#include "vulkan/kernel.h"

namespace etendue {

/// How kernels read the tables of the scene, see shaders/scene.glsl.
enum class TableLoads { texel_buffer, storage_buffer };

/// Texel buffers, unless a table of the scene is too long for those of the device and not for its storage buffers.
/// Throws Error(device_lost) naming limits, needed and available when neither will do, or `wanted` will not.
TableLoads choose_table_loads(const vulkan::Context& context, const CompiledScene& scene,
                              std::optional<TableLoads> wanted = {});

/// Bindings of every kernel, as shaders/gpu_types.h numbers them.
std::vector<vulkan::Binding> kernel_bindings(TableLoads loads = TableLoads::texel_buffer);

/// Rounds of the two bisections that choose a light: ceil(log2) of what there is to choose from.
struct LightRounds {
  std::uint32_t shapes = 0, primitives = 0;
  explicit LightRounds(const CompiledScene& scene);
};

/// Specialization constants of every kernel that traces rays: tree, lights, and the few primitives outside the tree.
std::vector<vulkan::Specialization> scene_constants(const CompiledScene& scene);

/// What a scene takes on a device.
std::vector<DeviceNeed> scene_needs(const CompiledScene& scene);

class DeviceScene {
 public:
  /// The needs of the scene must have been checked.
  DeviceScene(const vulkan::Context& context, vulkan::Commands& commands, const CompiledScene& scene,
              TableLoads loads = TableLoads::texel_buffer);
  void bind(vulkan::BindingSet& set) const;

 private:
  struct Entry {
    std::uint32_t binding;
    vulkan::Buffer buffer;
    vulkan::TexelView view;  // of a table
  };
  const vulkan::Context& context_;
  vulkan::Commands& commands_;
  std::vector<Entry> entries_;
};

}  // namespace etendue
