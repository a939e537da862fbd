#include "gpu/device_scene.h"

#include <span>

#include <fmt/core.h>

#include "core/errors.h"

namespace etendue {
namespace {

void check_range(const vulkan::Context& context, const char* what, std::uint64_t needed) {
  const std::uint64_t available = context.limits().maxStorageBufferRange;
  if (needed <= available) return;
  throw Error(ExitCode::device_lost,
              fmt::format("The {} need {} bytes, but '{}' binds at most {} (maxStorageBufferRange); use a smaller mesh or another --device.", what,
                          needed, context.info().name, available));
}

}  // namespace

std::vector<vulkan::Binding> kernel_bindings() {
  std::vector<vulkan::Binding> bindings;
  for (std::uint32_t i = 0; i < gpu::kBindingCount; ++i) bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  bindings[gpu::kBindingFrame].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  return bindings;
}

DeviceScene::DeviceScene(const vulkan::Context& context, vulkan::Commands& commands, const CompiledScene& scene) {
  const auto add = [&](std::uint32_t binding, auto items, const char* what) {
    const auto bytes = std::as_bytes(std::span(items));
    const bool uniform = binding == gpu::kBindingFrame;
    if (!uniform) check_range(context, what, bytes.size());
    vulkan::Buffer buffer(context, bytes.size(), uniform ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                          vulkan::Buffer::Memory::device, what);
    commands.upload(buffer, 0, bytes);
    entries_.push_back({binding, std::move(buffer)});
  };
  add(gpu::kBindingFrame, std::span(&scene.frame, 1), "frame constants");
  add(gpu::kBindingNodes, std::span(scene.nodes), "BVH nodes");
  add(gpu::kBindingPrimitives, std::span(scene.primitives), "primitives");
  add(gpu::kBindingShapes, std::span(scene.shapes), "shapes");
  add(gpu::kBindingTriangles, std::span(scene.triangles), "triangle indices");
  add(gpu::kBindingNormals, std::span(scene.normals), "vertex normals");
  add(gpu::kBindingLightShapes, std::span(scene.light_shapes), "emitters");
  add(gpu::kBindingLightPrimitives, std::span(scene.light_primitives), "emitting primitives");
  add(gpu::kBindingFilter, std::span(scene.filter_knots), "reconstruction filter");
}

void DeviceScene::bind(vulkan::BindingSet& set) const {
  for (const Entry& entry : entries_) set.bind(entry.binding, entry.buffer);
}

}  // namespace etendue
