/// Descriptor sets: the layouts hold what the built kernels declare, and a device is asked for no more than that.

#include <map>
#include <set>
#include <span>
#include <utility>

#include <gtest/gtest.h>

#include "gpu/kernel_bindings.h"
#include "gpu/kernel_set.h"
#include "gpu_types.h"
#include "mutants.h"
#include "mutants/mutate.h"

namespace etendue {
namespace {

using Place = std::pair<std::uint32_t, std::uint32_t>;  // set and binding
using Places = std::map<Place, VkDescriptorType>;

// What a SPIR-V binary declares (specification, §3.42).
Places declared(std::span<const std::uint32_t> words) {
  constexpr std::uint32_t kPointer = 32, kVariable = 59, kDecorate = 71, kBinding = 33, kDescriptorSet = 34;
  constexpr std::uint32_t kStructure = 5341;  // OpTypeAccelerationStructureKHR
  const std::map<std::uint32_t, VkDescriptorType> of_storage_class = {{0, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER},
                                                                      {2, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
                                                                      {12, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}};
  std::map<std::uint32_t, Place> places;
  std::set<std::uint32_t> structures;  // that type and pointers to it
  Places out;
  for (std::size_t i = 5; i < words.size() && words[i] >> 16 != 0; i += words[i] >> 16) {
    const std::span<const std::uint32_t> w = words.subspan(i, words[i] >> 16);
    const std::uint32_t op = w[0] & 0xffffu;
    if (op == kDecorate && w[2] == kDescriptorSet) places[w[1]].first = w[3];
    if (op == kDecorate && w[2] == kBinding) places[w[1]].second = w[3];
    if (op == kStructure) structures.insert(w[1]);
    if (op == kPointer && structures.contains(w[3])) structures.insert(w[1]);
    if (op == kVariable && places.contains(w[2]))
      out[places[w[2]]] =
          structures.contains(w[1]) ? VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR : of_storage_class.at(w[3]);
  }
  return out;
}

Places in_layout(const std::vector<vulkan::Binding>& scene, const std::vector<vulkan::Binding>& kernel) {
  Places out;
  for (const vulkan::Binding& b : scene) out[{gpu::kSetScene, b.number}] = b.type;
  for (const vulkan::Binding& b : kernel) out[{gpu::kSetKernel, b.number}] = b.type;
  return out;
}

// Adds what the kernel declares to `used`.
void check(const char* name, std::span<const std::uint32_t> kernel, const Places& layout, Places& used) {
  const Places places = declared(kernel);
  EXPECT_GE(places.size(), 3u) << name;
  for (const auto& [place, type] : places) {
    const auto found = layout.find(place);
    ASSERT_NE(found, layout.end()) << name << " declares set " << place.first << " binding " << place.second;
    EXPECT_EQ(found->second, type) << name << ", set " << place.first << " binding " << place.second;
    used[place] = type;
  }
}

void check_kernels(const KernelSet& kernels, TableLoads loads, bool queries = false) {
  const auto scene = scene_bindings(loads, queries);
  const Places film = in_layout(scene, film_bindings()), requests = in_layout(scene, request_bindings());
  Places of_film, of_requests;
  check("render", kernels.render, film, of_film);
  check("take_samples", kernels.take_samples, film, of_film);
  Places of_plain;
  check("render_plain", kernels.render_plain, film, of_plain);
  check("trace_samples_plain", kernels.trace_samples_plain, requests, of_plain);
  check("trace_path_plain", kernels.trace_path_plain, requests, of_plain);
  if (!queries) {
    check("profile", kernels.profile, film, of_film);
    check("profile_subgroups", kernels.profile_subgroups, film, of_film);
  }
  check("trace_samples", kernels.trace_samples, requests, of_requests);
  check("trace_path", kernels.trace_path, requests, of_requests);
  check("trace_rays", kernels.trace_rays, requests, of_requests);
  check("bsdf_samples", kernels.bsdf_samples, requests, of_requests);
  EXPECT_EQ(of_film, film) << "a binding that no kernel declares";
  EXPECT_EQ(of_requests, requests);
}

TEST(GpuLayout, HoldsWhatKernelsDeclareAndNothingElse) {
  check_kernels(kernel_set(TableLoads::texel_buffer), TableLoads::texel_buffer);
  check_kernels(kernel_set(TableLoads::storage_buffer), TableLoads::storage_buffer);
  check_kernels(query_kernel_set(), TableLoads::texel_buffer, true);
  check_kernels(kernels_with(gpu::kMutantNone), TableLoads::texel_buffer);
}

// Ids of the specialization constants that a kernel declares.
std::set<std::uint32_t> constants_of(std::span<const std::uint32_t> kernel) {
  constexpr std::uint32_t kDecorate = 71, kSpecId = 1, kHeaderWords = 5;
  std::set<std::uint32_t> out;
  for (std::size_t i = kHeaderWords; i < kernel.size(); i += kernel[i] >> 16)
    if ((kernel[i] & 0xffffu) == kDecorate && kernel[i + 2] == kSpecId) out.insert(kernel[i + 3]);
  return out;
}

// What is a constant of the render kernel and none of the plain one must make the host choose the former, or place the
// data of a feature that does.
TEST(GpuLayout, ThePlainKernelLacksWhatTheHostKnowsThatItLacks) {
  const std::set<std::uint32_t> details = {gpu::kConstantEnvironmentTexelRows,
                                           gpu::kConstantEnvironmentTexelsAt,
                                           gpu::kConstantEnvironmentColumnLevels,
                                           gpu::kConstantDeltaLightsAt,
                                           gpu::kConstantPlacesAt,
                                           gpu::kConstantMaterialTexturesAt,
                                           gpu::kConstantTextureUsesAt,
                                           gpu::kConstantTexelsAt,
                                           gpu::kConstantTransmittancesAt,
                                           gpu::kConstantCountPasses,
                                           gpu::kConstantTexturesAt,
                                           gpu::kConstantInstanceAttributesAt,
                                           gpu::kConstantAttributesAt};
  const KernelSet kernels = kernel_set(TableLoads::texel_buffer);
  const auto plain_with = [](std::uint32_t id, std::uint32_t value) {
    return is_plain(std::vector<vulkan::Specialization>{{id, value}});
  };
  const std::set<std::uint32_t> plain = constants_of(kernels.render_plain);
  EXPECT_LT(kernels.render_plain.size(), kernels.render.size() * 2 / 3);
  for (const std::uint32_t id : constants_of(kernels.render)) {
    EXPECT_TRUE(plain_with(id, 0)) << id;
    if (plain.contains(id) || details.contains(id)) continue;
    EXPECT_FALSE(plain_with(id, 1)) << "the plain kernel knows nothing of constant " << id;
  }
  EXPECT_TRUE(plain_with(gpu::kConstantBsdfsUsed, 7));
  EXPECT_FALSE(plain_with(gpu::kConstantBsdfsUsed, 8));
  EXPECT_TRUE(plain_with(gpu::kConstantEnvironment, gpu::kEnvironmentGradient));
  EXPECT_FALSE(plain_with(gpu::kConstantEnvironment, gpu::kEnvironmentPicture));
}

// The least that a Vulkan device may offer (specification, "Required Limits").
VkPhysicalDeviceLimits least_limits() {
  VkPhysicalDeviceLimits limits{};
  limits.maxBoundDescriptorSets = 4;
  limits.maxPerStageDescriptorStorageBuffers = 4;
  limits.maxDescriptorSetStorageBuffers = 24;
  limits.maxPerStageDescriptorSampledImages = 16;
  limits.maxDescriptorSetSampledImages = 96;
  limits.maxPerStageDescriptorUniformBuffers = 12;
  limits.maxPerStageResources = 128;
  limits.maxPushConstantsSize = 128;
  limits.maxUniformBufferRange = 16384;
  limits.maxComputeWorkGroupInvocations = 128;
  limits.maxComputeWorkGroupSize[0] = 128;
  return limits;
}

TEST(GpuLayout, EveryVulkanDeviceCanBindIt) {
  EXPECT_EQ(kernel_requirements(TableLoads::texel_buffer).missing(least_limits()), "");
  // Storage buffers are the way out for long tables; 8 are what most devices have at the least.
  VkPhysicalDeviceLimits limits = least_limits();
  limits.maxPerStageDescriptorStorageBuffers = 8;
  EXPECT_EQ(kernel_requirements(TableLoads::storage_buffer).missing(limits), "");
  EXPECT_EQ(kernel_requirements(TableLoads::texel_buffer).missing(limits), "");
}

TEST(GpuLayout, RequirementsFollowTheLayout) {
  for (const TableLoads loads : {TableLoads::texel_buffer, TableLoads::storage_buffer}) {
    const vulkan::Requirements needed = kernel_requirements(loads);
    std::map<VkDescriptorType, std::uint32_t> counts;
    for (const auto& [place, type] : in_layout(scene_bindings(loads), film_bindings())) ++counts[type];
    EXPECT_EQ(needed.storage_buffers, counts[VK_DESCRIPTOR_TYPE_STORAGE_BUFFER]);
    EXPECT_EQ(needed.sampled_images, counts[VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER]);
    EXPECT_EQ(needed.uniform_buffers, counts[VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER]);
  }
}

TEST(GpuLayout, WhatIsMissingIsNamed) {
  const vulkan::Requirements needed = kernel_requirements(TableLoads::storage_buffer);
  EXPECT_EQ(needed.missing(least_limits()),
            "it gives a kernel 4 storage buffers (maxPerStageDescriptorStorageBuffers), 7 are needed");
  VkPhysicalDeviceLimits limits = least_limits();
  limits.maxPerStageDescriptorStorageBuffers = 8;
  limits.maxComputeWorkGroupSize[0] = 32;
  EXPECT_EQ(needed.missing(limits),
            "it gives a kernel 32 lanes of a workgroup (maxComputeWorkGroupInvocations), 64 are needed");
}

}  // namespace
}  // namespace etendue
