#include "gpu/device_scene.h"

#include <algorithm>
#include <bit>
#include <span>

#include <fmt/core.h>

#include "core/errors.h"

namespace etendue {
namespace {

// Every table the kernels read through texelFetch; the rest of the scene is uniform.
constexpr std::uint32_t kTables[] = {gpu::kBindingRecords, gpu::kBindingShapes,      gpu::kBindingTriangles,
                                     gpu::kBindingNormals, gpu::kBindingLightShapes, gpu::kBindingLightPrimitives};

// Bit i for the material kBsdf… = i.
std::uint32_t bsdfs_used(const CompiledScene& scene) {
  std::uint32_t used = 0;
  for (const gpu::Shape& shape : scene.shapes) used |= 1u << shape.bsdf;
  return used;
}

bool has_sphere_lights(const CompiledScene& scene) {
  return std::any_of(
      scene.light_primitives.begin(), scene.light_primitives.end(),
      [&](const gpu::LightPrimitive& light) { return scene.records[light.slot].c.w == gpu::kPrimitiveSphere; });
}

}  // namespace

LightRounds::LightRounds(const CompiledScene& scene) {
  std::uint32_t most = 1;
  for (const gpu::LightShape& light : scene.light_shapes) most = std::max(most, light.primitive_count);
  shapes = static_cast<std::uint32_t>(std::bit_width(std::max<std::size_t>(scene.light_shapes.size(), 1) - 1));
  primitives = static_cast<std::uint32_t>(std::bit_width(most - 1));
}

std::vector<vulkan::Binding> kernel_bindings() {
  std::vector<vulkan::Binding> bindings;
  for (std::uint32_t i = 0; i < gpu::kBindingCount; ++i) bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  bindings[gpu::kBindingFrame].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  for (const std::uint32_t table : kTables) bindings[table].type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  return bindings;
}

std::vector<vulkan::Specialization> scene_constants(const CompiledScene& scene) {
  const LightRounds light_rounds(scene);
  std::vector<vulkan::Specialization> constants = {{8, std::max(1u, scene.tree_depth)},
                                                   {9, scene.has_spheres ? 1u : 0u},
                                                   {10, scene.few_triangles},
                                                   {11, scene.few_spheres},
                                                   {12, light_rounds.shapes},
                                                   {13, light_rounds.primitives},
                                                   {14, bsdfs_used(scene)},
                                                   {15, scene.normals.empty() ? 0u : 1u},
                                                   {16, has_sphere_lights(scene) ? 1u : 0u}};
  for (std::uint32_t i = 0; i < scene.few_triangles + scene.few_spheres; ++i) {
    const gpu::Record& record = scene.records[i];
    const std::uint32_t first = gpu::kFewConstants + 9 * i;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const int axis = static_cast<int>(k);
      constants.push_back({first + k, record.a[axis]});
      constants.push_back({first + 3 + k, record.b[axis]});
      constants.push_back({first + 6 + k, record.c[axis]});
    }
  }
  return constants;
}

DeviceScene::DeviceScene(const vulkan::Context& context, vulkan::Commands& commands, const CompiledScene& scene)
    : context_(context), commands_(commands) {
  add_uniform(gpu::kBindingFrame, std::as_bytes(std::span(&scene.frame, 1)), "frame constants");
  add_table(gpu::kBindingRecords, std::as_bytes(std::span(scene.records)), "tree");
  add_table(gpu::kBindingShapes, std::as_bytes(std::span(scene.shapes)), "shapes");
  add_table(gpu::kBindingTriangles, std::as_bytes(std::span(scene.triangles)), "triangle indices");
  add_table(gpu::kBindingNormals, std::as_bytes(std::span(scene.normals)), "vertex normals");
  add_table(gpu::kBindingLightShapes, std::as_bytes(std::span(scene.light_shapes)), "emitters");
  add_table(gpu::kBindingLightPrimitives, std::as_bytes(std::span(scene.light_primitives)), "emitting primitives");
  const auto knots = std::as_bytes(std::span(scene.filter_knots));
  entries_.push_back(
      {gpu::kBindingFilter, upload(knots, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "reconstruction filter"), {}});
}

vulkan::Buffer DeviceScene::upload(std::span<const std::byte> bytes, VkBufferUsageFlags usage, const char* what) {
  vulkan::Buffer buffer(context_, bytes.size(), usage, vulkan::Buffer::Memory::device, what);
  commands_.upload(buffer, 0, bytes);
  return buffer;
}

void DeviceScene::add_uniform(std::uint32_t binding, std::span<const std::byte> bytes, const char* what) {
  entries_.push_back({binding, upload(bytes, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, what), {}});
}

void DeviceScene::add_table(std::uint32_t binding, std::span<const std::byte> bytes, const char* what) {
  const std::uint64_t texels = bytes.size() / sizeof(gpu::uvec4);
  const std::uint64_t available = context_.limits().maxTexelBufferElements;
  if (texels > available) {
    throw Error(ExitCode::device_lost, fmt::format("The table '{}' needs {} texels, but '{}' reads at most {} "
                                                   "(maxTexelBufferElements); use a smaller mesh or another --device.",
                                                   what, texels, context_.info().name, available));
  }
  vulkan::Buffer buffer = upload(bytes, VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT, what);
  vulkan::TexelView view = vulkan::make_texel_view(context_, buffer, VK_FORMAT_R32G32B32A32_UINT);
  entries_.push_back({binding, std::move(buffer), std::move(view)});
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
