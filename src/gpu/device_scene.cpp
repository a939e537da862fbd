#include "gpu/device_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include <fmt/core.h>

#include "compile/node_layout.h"
#include "core/errors.h"

namespace etendue {
namespace {

// Of one layout for all kernels.
constexpr std::uint32_t kPushConstantBytes = sizeof(gpu::Pass);
static_assert(sizeof(gpu::BsdfProbePass) == kPushConstantBytes);

struct Table {
  std::uint32_t binding;
  const char* what;
  std::span<const std::byte> bytes;
};

// Everything that is read by load_<table> in shaders/scene.glsl; the rest of the scene is uniform.
std::array<Table, 8> tables(const CompiledScene& scene) {
  return {{{gpu::kBindingRecords, "tree", std::as_bytes(std::span(scene.records))},
           {gpu::kBindingShapes, "shapes", std::as_bytes(std::span(scene.shapes))},
           {gpu::kBindingTriangles, "triangle indices", std::as_bytes(std::span(scene.triangles))},
           {gpu::kBindingNormals, "vertex normals", std::as_bytes(std::span(scene.normals))},
           {gpu::kBindingLightShapes, "emitters", std::as_bytes(std::span(scene.light_shapes))},
           {gpu::kBindingLightPrimitives, "emitting primitives", std::as_bytes(std::span(scene.light_primitives))},
           {gpu::kBindingLightPairs, "light tree", std::as_bytes(std::span(scene.light_pairs))},
           {gpu::kBindingLightTrails, "trails of the light tree", std::as_bytes(std::span(scene.light_trails))}}};
}

// Bit i for the material kBsdf… = i.
std::uint32_t bsdfs_used(const CompiledScene& scene) {
  std::uint32_t used = 0;
  for (const gpu::Shape& shape : scene.shapes) used |= 1u << shape.bsdf;
  return used;
}

bool has_sphere_lights(const CompiledScene& scene) {
  const TreeReader<gpu::kBvhWidth> tree(scene.records);
  return std::any_of(
      scene.light_primitives.begin(), scene.light_primitives.end(),
      [&](const gpu::LightPrimitive& light) { return tree.primitive(light.slot).kind == gpu::kPrimitiveSphere; });
}

}  // namespace

LightRounds::LightRounds(const CompiledScene& scene) {
  std::uint32_t most = 1;
  for (const gpu::LightShape& light : scene.light_shapes) most = std::max(most, light.primitive_count);
  shapes = static_cast<std::uint32_t>(std::bit_width(std::max<std::size_t>(scene.light_shapes.size(), 1) - 1));
  primitives = static_cast<std::uint32_t>(std::bit_width(most - 1));
}

TableLoads choose_table_loads(const vulkan::Context& context, const CompiledScene& scene,
                              std::optional<TableLoads> wanted) {
  Table longest{};
  for (const Table& table : tables(scene)) {
    if (table.bytes.size() >= longest.bytes.size()) longest = table;
  }
  const std::uint64_t texels = longest.bytes.size() / sizeof(gpu::uvec4);
  const bool fits_texels = texels <= context.limits().maxTexelBufferElements;
  const bool fits_storage = longest.bytes.size() <= context.limits().maxStorageBufferRange;
  if (fits_texels && wanted != TableLoads::storage_buffer) return TableLoads::texel_buffer;
  if (fits_storage && wanted != TableLoads::texel_buffer) return TableLoads::storage_buffer;
  throw Error(ExitCode::device_lost,
              fmt::format("The table '{}' of the scene has {} bytes, but '{}' reads at most {} texels of 16 bytes "
                          "(maxTexelBufferElements) or {} bytes (maxStorageBufferRange); use a smaller mesh or another "
                          "--device.",
                          longest.what, longest.bytes.size(), context.info().name,
                          context.limits().maxTexelBufferElements, context.limits().maxStorageBufferRange));
}

std::vector<vulkan::Binding> kernel_bindings(TableLoads loads) {
  std::vector<vulkan::Binding> bindings;
  for (std::uint32_t i = 0; i < gpu::kBindingCount; ++i) bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  bindings[gpu::kBindingFrame].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  if (loads == TableLoads::texel_buffer) {
    for (const Table& table : tables({})) bindings[table.binding].type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  }
  return bindings;
}

std::vector<DeviceNeed> scene_needs(const CompiledScene& scene) {
  std::vector<DeviceNeed> needs;
  for (const Table& table : tables(scene)) needs.push_back({table.what, table.bytes.size()});
  return needs;
}

std::vector<vulkan::Specialization> scene_constants(const CompiledScene& scene) {
  const LightRounds light_rounds(scene);
  std::vector<vulkan::Specialization> constants = {{gpu::kConstantStackSize, std::max(1u, scene.tree_depth)},
                                                   {gpu::kConstantHasSpheres, scene.has_spheres ? 1u : 0u},
                                                   {gpu::kConstantFewTriangles, scene.few_triangles},
                                                   {gpu::kConstantFewSpheres, scene.few_spheres},
                                                   {gpu::kConstantLightShapeRounds, light_rounds.shapes},
                                                   {gpu::kConstantLightPrimitiveRounds, light_rounds.primitives},
                                                   {gpu::kConstantBsdfsUsed, bsdfs_used(scene)},
                                                   {gpu::kConstantVertexNormals, scene.normals.empty() ? 0u : 1u},
                                                   {gpu::kConstantSphereLights, has_sphere_lights(scene) ? 1u : 0u},
                                                   {gpu::kConstantTreeRoot, scene.tree_root}};
  for (std::uint32_t i = 0; i < scene.few_triangles + scene.few_spheres; ++i) {
    for (std::uint32_t k = 0; k < gpu::kFewFloats; ++k) {
      const gpu::uvec4& texel = scene.records[gpu::kRecordTexels * i + k / 3];
      constants.push_back({gpu::kConstantFew + gpu::kFewFloats * i + k, texel[static_cast<int>(k % 3)]});
    }
  }
  return constants;
}

DeviceScene::DeviceScene(std::shared_ptr<GpuDevice> device, const CompiledScene& scene,
                         std::optional<TableLoads> wanted, std::span<const DeviceNeed> planned)
    : device_(std::move(device)),
      loads_(choose_table_loads(*device_->context, scene, wanted)),
      facts_(scene),
      light_rounds_(scene),
      has_tree_(scene.tree_root != gpu::kNone),
      light_tree_depth_(scene.light_tree_depth),
      constants_(scene_constants(scene)),
      layout_(*device_->context, kernel_bindings(loads_), kPushConstantBytes) {
  std::vector<DeviceNeed> needs = scene_needs(scene);
  needs.insert(needs.end(), planned.begin(), planned.end());
  check_needs(needs, limits_of(*device_->context));
  const bool texels = loads_ == TableLoads::texel_buffer;
  const VkBufferUsageFlags usage =
      texels ? VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  for (const Table& table : tables(scene)) {
    vulkan::Buffer buffer(*device_->context, table.bytes.size(), usage, vulkan::Buffer::Memory::device, table.what);
    device_->commands.upload(buffer, 0, table.bytes);
    vulkan::TexelView view;
    if (texels) view = vulkan::make_texel_view(*device_->context, buffer, VK_FORMAT_R32G32B32A32_UINT);
    entries_.push_back({table.binding, std::move(buffer), std::move(view)});
  }
}

void DeviceScene::bind(vulkan::BindingSet& set) const {
  for (const Entry& entry : entries_) {
    if (entry.view) {
      set.bind(entry.binding, entry.view);
    } else {
      set.bind(entry.binding, entry.buffer);
    }
  }
}

}  // namespace etendue
