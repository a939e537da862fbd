#pragma once
/// A compiled scene in device memory, bound for the kernels.

#include <optional>

#include "compile/compiled_view.h"
#include "gpu/device_limits.h"
#include "gpu/gpu_device.h"
#include "gpu/kernel_bindings.h"

namespace etendue {

/// Texel buffers, unless a table of the scene is too long for those of the device and not for its storage buffers.
/// Throws Error(lost) naming limits, needed and available when neither will do, or `wanted` will not.
TableLoads choose_table_loads(const vulkan::Context& context, const CompiledScene& scene,
                              std::optional<TableLoads> wanted = {});

/// Rounds of a kernel's loops, at most: of the bisections that choose a light or a direction of the environment,
/// ceil(log2) of what there is to choose from; at a hit, through adapters and textures.
struct LoopRounds {
  std::uint32_t instances = 0, primitives = 0;
  std::uint32_t environment_rows = 0, environment_columns = 0;
  std::uint32_t distant = 0;
  std::uint32_t materials = 0;
  explicit LoopRounds(const CompiledScene& scene);
};

/// Where tables begin in the buffers that they share: specialization constants of every kernel.
std::vector<vulkan::Specialization> table_places(const CompiledScene& scene);

/// Specialization constants of every kernel that traces rays: those places, tree, lights, and the few primitives
/// outside the tree. All but that of the light tree's depth: whether the tree is used is up to the view.
std::vector<vulkan::Specialization> scene_constants(const CompiledScene& scene);

/// What a scene takes on a device.
std::vector<DeviceNeed> scene_needs(const CompiledScene& scene);
/// The part of it that is known before the scene is compiled: vertex normals and the triangles that name them.
DeviceNeed least_scene_need(const Scene& scene);

/// The tables in device memory, and what views and kernels need to know of them. The compiled scene may go once it is
/// made.
class DeviceScene {
 public:
  /// Throws Error(lost), before anything is uploaded, when the device cannot hold or read the tables, or not
  /// beside what else is `planned`.
  DeviceScene(std::shared_ptr<GpuDevice> device, const CompiledScene& scene, std::optional<TableLoads> wanted = {},
              std::span<const DeviceNeed> planned = {});

  DeviceScene(const DeviceScene&) = delete;
  DeviceScene& operator=(const DeviceScene&) = delete;

  GpuDevice& device() const { return *device_; }
  const std::shared_ptr<GpuDevice>& device_pointer() const { return device_; }
  TableLoads loads() const { return loads_; }
  const SceneFacts& facts() const { return facts_; }
  const LoopRounds& loop_rounds() const { return loop_rounds_; }
  bool has_tree() const { return has_tree_; }
  std::uint32_t light_tree_depth() const { return light_tree_depth_; }
  /// See scene_constants.
  const std::vector<vulkan::Specialization>& constants() const { return constants_; }
  /// Layouts of the kernels that read this scene, and its set 0, bound for them.
  const vulkan::SetLayout& set_layout() const { return set_layout_; }
  const KernelBindings& film_kernels() const { return film_kernels_; }
  const KernelBindings& request_kernels() const { return request_kernels_; }
  const vulkan::BindingSet& set() const { return set_; }

 private:
  struct Entry {
    vulkan::Buffer buffer;
    vulkan::TexelView view;  // none for storage buffers
  };
  std::shared_ptr<GpuDevice> device_;
  TableLoads loads_;
  SceneFacts facts_;
  LoopRounds loop_rounds_;
  bool has_tree_;
  std::uint32_t light_tree_depth_;
  std::vector<vulkan::Specialization> constants_;
  vulkan::SetLayout set_layout_;
  KernelBindings film_kernels_, request_kernels_;
  std::vector<Entry> entries_;
  vulkan::BindingSet set_;
};

}  // namespace etendue
