#include "gpu/device_scene.h"

#include <span>

#include <fmt/core.h>

#include "core/errors.h"

namespace etendue {
namespace {

void check_range(const vulkan::Context& context, const char* what, std::uint64_t needed) {
  const std::uint64_t available = context.limits().maxStorageBufferRange;
  if (needed <= available) return;
  throw Error(ExitCode::device_lost, fmt::format("The {} need {} bytes, but '{}' binds at most {} "
                                                 "(maxStorageBufferRange); use a smaller mesh or another --device.",
                                                 what, needed, context.info().name, available));
}

}  // namespace

std::vector<vulkan::Binding> kernel_bindings() {
  std::vector<vulkan::Binding> bindings;
  for (std::uint32_t i = 0; i < gpu::kBindingCount; ++i) bindings.push_back({i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER});
  bindings[gpu::kBindingFrame].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  bindings[gpu::kBindingFewPrimitives].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  bindings[gpu::kBindingRecords].type = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  return bindings;
}

DeviceScene::DeviceScene(const vulkan::Context& context, vulkan::Commands& commands, const CompiledScene& scene) {
  const auto add = [&](std::uint32_t binding, auto items, const char* what) {
    const auto bytes = std::as_bytes(std::span(items));
    const bool uniform = binding == gpu::kBindingFrame || binding == gpu::kBindingFewPrimitives;
    if (!uniform) check_range(context, what, bytes.size());
    vulkan::Buffer buffer(context, bytes.size(),
                          uniform ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                          vulkan::Buffer::Memory::device, what);
    commands.upload(buffer, 0, bytes);
    entries_.push_back({binding, std::move(buffer)});
  };
  add(gpu::kBindingFrame, std::span(&scene.frame, 1), "frame constants");
  std::vector<gpu::Record> few(scene.records.begin(), scene.records.begin() + scene.few_triangles + scene.few_spheres);
  few.resize(gpu::kFewPrimitives);
  add(gpu::kBindingFewPrimitives, std::span(few), "primitives");
  add(gpu::kBindingShapes, std::span(scene.shapes), "shapes");
  add(gpu::kBindingTriangles, std::span(scene.triangles), "triangle indices");
  add(gpu::kBindingNormals, std::span(scene.normals), "vertex normals");
  add(gpu::kBindingLightShapes, std::span(scene.light_shapes), "emitters");
  add(gpu::kBindingLightPrimitives, std::span(scene.light_primitives), "emitting primitives");
  add(gpu::kBindingFilter, std::span(scene.filter_knots), "reconstruction filter");
  upload_records(context, commands, scene.records);
}

void DeviceScene::upload_records(const vulkan::Context& context, vulkan::Commands& commands,
                                 const std::vector<gpu::Record>& records) {
  const auto bytes = std::as_bytes(std::span(records));
  const std::uint64_t texels = bytes.size() / sizeof(gpu::uvec4);
  const std::uint64_t available = context.limits().maxTexelBufferElements;
  if (texels > available) {
    throw Error(ExitCode::device_lost, fmt::format("The tree and the primitives need {} texels, but '{}' reads at most "
                                                   "{} (maxTexelBufferElements); use a smaller mesh "
                                                   "or another --device.",
                                                   texels, context.info().name, available));
  }
  records_ = vulkan::Buffer(context, bytes.size(), VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT,
                            vulkan::Buffer::Memory::device, "tree");
  commands.upload(records_, 0, bytes);
  record_view_ = vulkan::make_texel_view(context, records_, VK_FORMAT_R32G32B32A32_UINT);
}

void DeviceScene::bind(vulkan::BindingSet& set) const {
  set.bind(gpu::kBindingRecords, record_view_);
  for (const Entry& entry : entries_) set.bind(entry.binding, entry.buffer);
}

}  // namespace etendue
