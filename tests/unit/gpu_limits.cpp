// Needs held against made-up limits: each limit is named with what is needed and what is there.

#include "gpu/device_limits.h"

#include <algorithm>
#include <functional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compile/compiled_scene.h"
#include "core/errors.h"
#include "gpu/device_scene.h"
#include "vulkan/context.h"

namespace etendue {
namespace {

using Kind = DeviceNeed::Kind;

const DeviceLimits kDevice{.device = "Toy",
                           .max_storage_buffer_range = 500,
                           .max_memory_allocation_size = 12000,
                           .memory = 20000,
                           .memory_name = "size of its memory heap"};

std::string refusal(const std::vector<DeviceNeed>& needs, const DeviceLimits& limits = kDevice) {
  try {
    check_needs(needs, limits);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::lost);
    return error.what();
  }
  return "";
}

TEST(DeviceLimits, WhatFitsIsFine) {
  EXPECT_EQ(refusal({}), "");
  EXPECT_EQ(refusal({{"tree", 12000}, {"film", 7500, Kind::memory}, {"filter", 500, Kind::storage}}), "");
}

TEST(DeviceLimits, EachIsNamed) {
  const std::string remedy = "; use coarser meshes or a smaller image, another --device, or --device reference.";
  EXPECT_EQ(refusal({{"filter", 501, Kind::storage}}),
            "The filter needs 501 bytes in one binding, but 'Toy' has 500 (maxStorageBufferRange)" + remedy);
  EXPECT_EQ(refusal({{"tree", 12001}}),
            "The tree needs 12001 bytes in one piece, but 'Toy' has 12000 (maxMemoryAllocationSize)" + remedy);
  EXPECT_EQ(refusal({{"tree", 11000}, {"film", 9001, Kind::memory}}),
            "The render, most of it the tree of 11000 bytes, needs 20001 bytes of device memory, but 'Toy' has 20000 "
            "(size of its memory heap)" +
                remedy);
}

TEST(DeviceLimits, AFilmIsCutAndOnlyItsSumCounts) {
  EXPECT_EQ(refusal({{"film", 20000, Kind::memory}}), "");
  EXPECT_THAT(refusal({{"film", 20001, Kind::memory}}), testing::HasSubstr("of device memory"));
}

TEST(DeviceLimits, WhatIsKnownBeforeCompilingIsPartOfWhatIsNeeded) {
  TriangleMesh mesh{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
                    .normals = std::vector<glm::dvec3>(4, {0, 0, 1}),
                    .triangles = {{0, 1, 2}, {2, 1, 3}, {0, 1, 3}}};
  Scene scene;
  scene.add(mesh);
  scene.add(Sphere{});
  mesh.normals.clear();
  scene.add(mesh);
  scene.instances.push_back(scene.instances.front());
  EXPECT_EQ(least_scene_need(scene).bytes, 2u * 3 * 16);
  const CompiledScene compiled = compile_scene(scene);
  EXPECT_EQ(least_scene_need(scene).bytes, compiled.vertex_normals.size() * sizeof(gpu::uvec4));
  EXPECT_EQ(least_scene_need(Scene{}).bytes, 0u);
}

TEST(DeviceRank, HardwareOfAnyKindComesBeforeCpuDriversAndSwiftShaderLast) {
  const std::vector<int> ranks = {
      vulkan::device_rank(VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU, VK_DRIVER_ID_NVIDIA_PROPRIETARY),
      vulkan::device_rank(VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU, VK_DRIVER_ID_MESA_RADV),
      vulkan::device_rank(VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU, VK_DRIVER_ID_MESA_VENUS),
      vulkan::device_rank(VK_PHYSICAL_DEVICE_TYPE_OTHER, VK_DRIVER_ID_MESA_DOZEN),
      vulkan::device_rank(VK_PHYSICAL_DEVICE_TYPE_CPU, VK_DRIVER_ID_MESA_LLVMPIPE),
      vulkan::device_rank(VK_PHYSICAL_DEVICE_TYPE_CPU, VkDriverId{}),
      vulkan::device_rank(VK_PHYSICAL_DEVICE_TYPE_CPU, VK_DRIVER_ID_GOOGLE_SWIFTSHADER)};
  EXPECT_TRUE(std::ranges::adjacent_find(ranks, std::greater_equal<>()) == ranks.end())
      << testing::PrintToString(ranks);
}

}  // namespace
}  // namespace etendue
