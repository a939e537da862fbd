/// A device with the least that Vulkan guarantees, and one that lacks a single thing: it renders the same bytes, or it
/// is refused with the name of that thing.

#include <initializer_list>

#include "render_fixture.h"

namespace etendue::faults {
namespace {

using testing::HasSubstr;

class DeviceLacks : public RenderTest {
 protected:
  ProcessResult render_without(const std::string& thing, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = render({"--spp", "2", "--film", "-o", "x.exr"});
    arguments.insert(arguments.end(), more.begin(), more.end());
    ProcessOptions options = fault("lacks", 0);
    options.environment["ETENDUE_FAULT_LACKS"] = thing;
    return run(arguments, options);
  }
};

// Without a tree, with a tree, and with spots and projectors.
TEST_F(DeviceLacks, TheLeastThatVulkanGuaranteesSuffices) {
  for (const char* scene : {"cbox-sphere", "bubble", "stage"}) {
    const auto render = [&](const char* out, const ProcessOptions& options) {
      const std::string file = std::string(SCENES_DIR "/") + scene + ".xml";
      expect_ok({"render", file, "--size", "100x75", "--spp", "2", "--film", "--force", "-o", out}, options);
    };
    render("all.exr", {});
    render("least.exr", fault("minimum", 0));
    expect_same("all.exr", "least.exr");
  }
}

TEST_F(DeviceLacks, ALimitThatDoesNotSufficeIsNamed) {
  for (const char* limit :
       {"maxBoundDescriptorSets", "maxPerStageDescriptorStorageBuffers", "maxDescriptorSetStorageBuffers",
        "maxPerStageDescriptorSampledImages", "maxDescriptorSetSampledImages", "maxPerStageDescriptorUniformBuffers",
        "maxPerStageResources", "maxPushConstantsSize", "maxUniformBufferRange", "maxComputeWorkGroupInvocations"}) {
    expect_error(render_without(limit), 4, std::string("(") + limit + ")");
    EXPECT_FALSE(exists("x.exr")) << limit;
  }
}

TEST_F(DeviceLacks, WhatIsNeededIsNamed) {
  expect_error(render_without("Vulkan 1.2"), 4, "it speaks Vulkan 1.1, 1.2 is needed");
  expect_error(render_without("compute"), 4, "it has no compute queue");
}

TEST_F(DeviceLacks, WhatIsNotNeededIsDoneWithout) {
  expect_ok(render({"--spp", "2", "--film", "-o", "all.exr"}));
  for (const char* thing :
       {"VK_EXT_external_memory_host", "VK_EXT_memory_budget", "VK_KHR_ray_query", "VK_KHR_acceleration_structure",
        "VK_KHR_deferred_host_operations", "VK_KHR_pipeline_executable_properties", "bufferDeviceAddress",
        "accelerationStructure", "rayQuery", "maxComputeSharedMemorySize"}) {
    const ProcessResult result = render_without(thing);
    EXPECT_EQ(result.code, 0) << thing << ": " << result.err;
    expect_same("all.exr", "x.exr");
  }
  const ProcessResult counted = render_without("ballot", {"--stats"});
  EXPECT_EQ(counted.code, 0) << counted.err;
  EXPECT_THAT(counted.out, HasSubstr("active lanes: unknown, the device has no subgroup ballots"));
}

TEST_F(DeviceLacks, RayQueriesNeedEachOfTheirParts) {
  const ProcessResult whole = render_without("", {"--traversal", "query"});
  if (whole.code != 0)
    return expect_error(whole, 4, "which '--traversal query' needs; '--traversal tree' does without");
  for (const char* extension : {"VK_KHR_ray_query", "VK_KHR_acceleration_structure", "VK_KHR_deferred_host_operations"})
    expect_error(render_without(extension, {"--traversal", "query"}), 4, std::string("the extension ") + extension);
  for (const char* feature : {"bufferDeviceAddress", "accelerationStructure", "rayQuery"})
    expect_error(render_without(feature, {"--traversal", "query"}), 4, std::string("the feature ") + feature);
}

}  // namespace
}  // namespace etendue::faults
