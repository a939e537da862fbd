#pragma once
/// A compiled scene in device memory, bound for the kernels.

#include <map>
#include <memory>
#include <optional>
#include <span>

#include "compile/compiled_view.h"
#include "gpu/device_limits.h"
#include "gpu/gpu_device.h"
#include "gpu/kernel_bindings.h"
#include "vulkan/acceleration.h"

namespace etendue {

struct TableGroup;  // tables that share a buffer

/// Texel buffers, unless a table of the scene is too long for those of the device but not for its storage buffers.
/// Throws Error(lost) with the limits, the need and what is available if neither is possible, or `wanted` is not.
TableLoads choose_table_loads(const vulkan::Context& context, const CompiledScene& scene,
                              std::optional<TableLoads> wanted = {});

/// Upper bounds for the iterations of a kernel's loops: ceil(log2) of the number of choices for the bisections that
/// choose a light; the levels of the tree for the search for a direction of the environment; and those at a hit,
/// through adapters and textures.
struct LoopRounds {
  std::uint32_t instances = 0, primitives = 0;
  std::uint32_t environment_rows = 0, environment_columns = 0;
  std::uint32_t distant = 0;
  std::uint32_t materials = 0;
  LoopRounds(const CompiledScene& scene, const CompiledLights& lights);
};

/// Start of each table in the shared buffers: specialization constants of every kernel.
std::vector<vulkan::Specialization> table_places(const CompiledScene& scene, const CompiledMaterials& materials,
                                                 const CompiledLights& lights);

/// Specialization constants of every kernel that traces rays: those places, tree, lights, and the few primitives
/// outside the tree. The depth of the light tree is missing, because the view decides whether that tree is used.
std::vector<vulkan::Specialization> scene_constants(const CompiledScene& scene, const CompiledMaterials& materials,
                                                    const CompiledLights& lights);

/// Device memory of a scene.
std::vector<DeviceNeed> scene_needs(const CompiledScene& scene);
/// The part known before the scene is compiled: vertex normals.
DeviceNeed least_scene_need(const Scene& scene);

/// The layouts and the set 0 for kernels that read tables in one way.
struct SceneLayouts {
  SceneLayouts(const vulkan::Context& context, TableLoads way, bool by_queries)
      : loads(way),
        queries(by_queries),
        set(context, scene_bindings(way, by_queries)),
        film_kernels(context, set, film_bindings()),
        request_kernels(context, set, request_bindings()) {}
  TableLoads loads;
  bool queries;
  vulkan::SetLayout set;
  KernelBindings film_kernels, request_kernels;
};

/// The tables in device memory, and what views and kernels need to know of them. The compiled scene may go once it is
/// made; where the driver of a CPU reads its tree in place, a second copy is not made and the scene stays.
class DeviceScene {
 public:
  using Layouts = std::shared_ptr<const SceneLayouts>;
  /// Throws Error(lost), before anything is uploaded, if the device cannot hold or read the tables, or not together
  /// with the memory `planned` for other purposes. Reuses the layouts of another scene of the device if they fit. With
  /// `queries`, the driver builds acceleration structures in place of the tree.
  DeviceScene(std::shared_ptr<GpuDevice> device, const std::shared_ptr<const CompiledScene>& compiled,
              std::optional<TableLoads> wanted = {}, std::span<const DeviceNeed> planned = {}, const Layouts& like = {},
              bool queries = false);
  /// The same scene as `base`, which was made from `scene`, but with other numbers in its materials and lights; both
  /// share the tree and the geometry. Throws Error(lost) if the device cannot read the tables.
  DeviceScene(const DeviceScene& base, const CompiledScene& scene, const CompiledMaterials& materials,
              const CompiledLights& lights);

  DeviceScene(const DeviceScene&) = delete;
  DeviceScene& operator=(const DeviceScene&) = delete;

  GpuDevice& device() const { return *device_; }
  const std::shared_ptr<GpuDevice>& device_pointer() const { return device_; }
  TableLoads loads() const { return loads_; }
  bool queries() const { return queries_; }
  const SceneFacts& facts() const { return facts_; }
  const LoopRounds& loop_rounds() const { return loop_rounds_; }
  bool has_tree() const { return has_tree_; }
  std::uint32_t light_tree_depth() const { return light_tree_depth_; }
  /// See scene_constants.
  const std::vector<vulkan::Specialization>& constants() const { return constants_; }
  const Layouts& layouts() const { return layouts_; }
  /// Layouts of the kernels that read this scene, and its set 0, bound for them.
  const vulkan::SetLayout& set_layout() const { return layouts_->set; }
  const KernelBindings& film_kernels() const { return layouts_->film_kernels; }
  const KernelBindings& request_kernels() const { return layouts_->request_kernels; }
  const vulkan::BindingSet& set() const { return set_; }

 private:
  struct Entry {
    vulkan::Buffer buffer;
    vulkan::TexelView view;  // none for storage buffers
  };
  std::shared_ptr<const Entry> finish(Entry entry);
  std::shared_ptr<const Entry> upload(const TableGroup& group);
  // Without a copy where the device can: `group` is a table of `owner` in pages of its own.
  std::shared_ptr<const Entry> use_in_place(const TableGroup& group, const std::shared_ptr<const CompiledScene>& owner);
  void bind(std::uint32_t binding, std::shared_ptr<const Entry> entry);
  void use_structures(std::uint32_t instances_at);

  std::shared_ptr<GpuDevice> device_;
  TableLoads loads_;
  bool queries_;
  SceneFacts facts_;
  LoopRounds loop_rounds_;
  bool has_tree_;
  std::uint32_t light_tree_depth_;
  std::vector<vulkan::Specialization> constants_;
  Layouts layouts_;
  std::map<std::uint32_t, std::shared_ptr<const Entry>> entries_;  // key: their bindings
  // The structures of the meshes, then that of their instances; and the slot of the first instance. Only for queries.
  std::shared_ptr<const std::vector<vulkan::AccelerationStructure>> structures_;
  std::uint32_t instances_at_ = 0;
  vulkan::BindingSet set_;
};

}  // namespace etendue
