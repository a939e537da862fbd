#include "vulkan/acceleration.h"

#include <algorithm>
#include <cstring>

#include <fmt/core.h>

#include "core/errors.h"
#include "vulkan/check.h"

namespace etendue::vulkan {
namespace {

VkAccelerationStructureTypeKHR type_of(StructureKind kind) {
  return kind == StructureKind::boxes ? VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR
                                      : VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
}

VkAccelerationStructureGeometryKHR geometry(StructureKind kind, VkDeviceAddress input) {
  VkAccelerationStructureGeometryKHR out{.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
  if (kind == StructureKind::boxes) {
    out.geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
    out.geometry.aabbs = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR,
                          .data = {.deviceAddress = input},
                          .stride = sizeof(VkAabbPositionsKHR)};
  } else {
    out.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    out.geometry.instances = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
                              .data = {.deviceAddress = input}};
  }
  return out;
}

VkAccelerationStructureBuildGeometryInfoKHR build_info(StructureKind kind,
                                                       const VkAccelerationStructureGeometryKHR& of) {
  return {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
          .type = type_of(kind),
          .flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR,
          .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
          .geometryCount = 1,
          .pGeometries = &of};
}

VkDeviceAddress address_of(const Context& context, const Buffer& buffer) {
  const VkBufferDeviceAddressInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = buffer.get()};
  return vkGetBufferDeviceAddress(context.device(), &info);
}

}  // namespace

StructureSize structure_size(const Context& context, StructureKind kind, std::uint32_t count) {
  const VkPhysicalDeviceAccelerationStructurePropertiesKHR& limits = context.structure_limits();
  const std::uint64_t most = kind == StructureKind::boxes ? limits.maxPrimitiveCount : limits.maxInstanceCount;
  if (count > most)
    throw Error(ErrorKind::lost, fmt::format("'{}' builds acceleration structures of up to {} {}, but the scene has "
                                             "{}; use --traversal tree.",
                                             context.info().name, most,
                                             kind == StructureKind::boxes ? "primitives" : "instances", count));
  const VkAccelerationStructureGeometryKHR of = geometry(kind, 0);
  const VkAccelerationStructureBuildGeometryInfoKHR info = build_info(kind, of);
  VkAccelerationStructureBuildSizesInfoKHR sizes{.sType =
                                                     VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
  vkGetAccelerationStructureBuildSizesKHR(context.device(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info,
                                          &count, &sizes);
  return {sizes.accelerationStructureSize,
          sizes.buildScratchSize + limits.minAccelerationStructureScratchOffsetAlignment};
}

AccelerationStructure::AccelerationStructure(const Context& context, Commands& commands, StructureKind kind,
                                             std::span<const std::byte> input, std::uint32_t count)
    : device_(context.device()) {
  const StructureSize size = structure_size(context, kind, count);
  constexpr VkBufferUsageFlags kAddressed = VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  memory_ = {context, size.kept, kAddressed | VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR,
             Buffer::Memory::device, "acceleration structure"};
  const VkAccelerationStructureCreateInfoKHR create{.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
                                                    .buffer = memory_.get(),
                                                    .size = size.kept,
                                                    .type = type_of(kind)};
  VkAccelerationStructureKHR structure = VK_NULL_HANDLE;
  check(vkCreateAccelerationStructureKHR(device_, &create, nullptr, &structure), "create an acceleration structure");
  structure_ = {device_, structure};

  // Instances must be at multiples of 16, which is not guaranteed for a buffer's address.
  constexpr VkDeviceSize kAlignment = 16;
  const Buffer in(context, input.size() + kAlignment,
                  kAddressed | VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR,
                  Buffer::Memory::device, "input of an acceleration structure");
  const Buffer scratch(context, size.scratch, kAddressed | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, Buffer::Memory::device,
                       "scratch memory of an acceleration structure");
  const auto aligned = [&](const Buffer& buffer, VkDeviceSize alignment) {
    const VkDeviceAddress at = address_of(context, buffer);
    return (at + alignment - 1) / alignment * alignment;
  };
  const VkDeviceAddress first = aligned(in, kAlignment);
  commands.upload(in, first - address_of(context, in), input);
  const VkAccelerationStructureGeometryKHR of = geometry(kind, first);
  VkAccelerationStructureBuildGeometryInfoKHR info = build_info(kind, of);
  info.dstAccelerationStructure = structure;
  info.scratchData.deviceAddress =
      aligned(scratch, context.structure_limits().minAccelerationStructureScratchOffsetAlignment);
  commands.build(info, {.primitiveCount = count});
}

std::uint64_t AccelerationStructure::address() const {
  const VkAccelerationStructureDeviceAddressInfoKHR info{
      .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
      .accelerationStructure = structure_.get()};
  return vkGetAccelerationStructureDeviceAddressKHR(device_, &info);
}

VkAccelerationStructureInstanceKHR structure_instance(const AccelerationStructure& boxes,
                                                      const float (&world_from_mesh)[3][4], std::uint32_t name) {
  VkAccelerationStructureInstanceKHR out{};
  static_assert(sizeof out.transform.matrix == sizeof world_from_mesh);
  std::memcpy(out.transform.matrix, world_from_mesh, sizeof world_from_mesh);
  out.instanceCustomIndex = name & 0xffffffu;
  out.mask = 0xff;
  out.accelerationStructureReference = boxes.address();
  return out;
}

}  // namespace etendue::vulkan
