/// Modules whose constants are fixed before a driver sees them.

#include "vulkan/specialize.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors.h"
#include "gpu/kernel_set.h"
#include "gpu_types.h"
#include "image_testing.h"
#include "vulkan/cache_files.h"
#include "vulkan/module_cache.h"

namespace etendue {
namespace {

using testing::HasSubstr;
using vulkan::specialize;

// How often each instruction of a SPIR-V module occurs (specification, §3.42).
std::map<std::uint32_t, int> instructions(std::span<const std::uint32_t> words) {
  std::map<std::uint32_t, int> out;
  for (std::size_t i = 5; i < words.size() && words[i] >> 16 != 0; i += words[i] >> 16) ++out[words[i] & 0xffffu];
  return out;
}
constexpr std::uint32_t kConstant = 43, kSpecConstantTrue = 48, kSpecConstantFalse = 49, kSpecConstant = 50,
                        kSpecConstantComposite = 51, kSpecConstantOp = 52, kFunction = 54, kArrayType = 28;

// The lengths of a module's arrays.
std::vector<std::uint32_t> array_lengths(std::span<const std::uint32_t> words) {
  std::map<std::uint32_t, std::uint32_t> constants;
  std::vector<std::uint32_t> out;
  for (std::size_t i = 5; i < words.size() && words[i] >> 16 != 0; i += words[i] >> 16) {
    const std::uint32_t op = words[i] & 0xffffu;
    if (op == kConstant) constants[words[i + 2]] = words[i + 3];
    if (op == kArrayType) out.push_back(constants.at(words[i + 3]));
  }
  return out;
}

const KernelSet kKernels = kernel_set(TableLoads::texel_buffer);

TEST(Specialize, LeavesNoConstantOpen) {
  ASSERT_GT(instructions(kKernels.render)[kSpecConstant], 50);
  auto found = instructions(specialize(kKernels.render, {}));
  for (const std::uint32_t op :
       {kSpecConstantTrue, kSpecConstantFalse, kSpecConstant, kSpecConstantComposite, kSpecConstantOp})
    EXPECT_EQ(found[op], 0) << op;
}

TEST(Specialize, TakesAwayWhatNoSurfaceHas) {
  const std::vector<vulkan::Specialization> one = {{gpu::kConstantBsdfsUsed, 1u << gpu::kBsdfDiffuse}};
  const std::vector<vulkan::Specialization> all = {{gpu::kConstantBsdfsUsed, 0xffffffffu}};
  const auto diffuse = specialize(kKernels.render, one), everything = specialize(kKernels.render, all);
  EXPECT_LT(diffuse.size() * 3, everything.size() * 2);
  EXPECT_LT(instructions(diffuse)[kFunction] + 40, instructions(everything)[kFunction]);
}

// Drivers are known that take the length in the module for that of the pipeline.
TEST(Specialize, ArraysHaveTheLengthAskedFor) {
  const std::vector<vulkan::Specialization> constants = {
      {gpu::kConstantStackSize, 11}, {gpu::kConstantTreeRoot, 0}, {gpu::kConstantFewCount, 0}};
  EXPECT_THAT(array_lengths(specialize(kKernels.trace_rays, constants)), testing::Contains(11u));
}

TEST(Specialize, PassesOverWhatTheModuleDoesNotHave) {
  const std::vector<vulkan::Specialization> foreign = {{4000000u, 7u}};
  EXPECT_EQ(specialize(kKernels.trace_rays, foreign), specialize(kKernels.trace_rays, {}));
}

TEST(Specialize, SaysWhatIsNoModule) {
  const std::vector<std::uint32_t> words(64, 0x12345678u);
  try {
    specialize(words, {});
    FAIL() << "took it";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::bug);
    EXPECT_THAT(error.what(), HasSubstr("A kernel cannot be specialized: "));
  }
}

class ModuleCacheTest : public testing::Test {
 protected:
  std::vector<std::filesystem::path> files() const {
    std::vector<std::filesystem::path> out;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) out.push_back(entry.path());
    return out;
  }
  testing_image::TempFolder folder_;
  vulkan::ModuleCache cache_{folder_.path()};
};

TEST_F(ModuleCacheTest, KeepsWhatSpecializeMakes) {
  const std::vector<vulkan::Specialization> one = {{gpu::kConstantStackSize, 11}},
                                            other = {{gpu::kConstantStackSize, 12}};
  EXPECT_FALSE(cache_.find(kKernels.trace_rays, one));
  EXPECT_EQ(cache_.specialized(kKernels.trace_rays, one), specialize(kKernels.trace_rays, one));
  EXPECT_EQ(cache_.find(kKernels.trace_rays, one), specialize(kKernels.trace_rays, one));
  EXPECT_FALSE(cache_.find(kKernels.trace_rays, other)) << "other constants";
  EXPECT_FALSE(cache_.find(kKernels.render, one)) << "another kernel";
  EXPECT_EQ(cache_.specialized(kKernels.trace_rays, one), specialize(kKernels.trace_rays, one));
  EXPECT_EQ(files().size(), 1u);
}

TEST_F(ModuleCacheTest, DamagedFilesAreMadeAgain) {
  const std::vector<std::uint32_t> made = cache_.specialized(kKernels.take_samples, {});
  const std::filesystem::path file = files().at(0);
  const std::string whole = vulkan::read_cached(file);
  std::vector<std::string> damaged = {"", "x", whole.substr(0, 16), whole.substr(0, whole.size() - 4), whole + "1234"};
  for (const std::size_t at : {std::size_t{3}, std::size_t{40}, whole.size() - 1}) {
    damaged.push_back(whole);
    damaged.back()[at] ^= 1;
  }
  for (const std::string& bytes : damaged) {
    std::ofstream(file, std::ios::binary) << bytes;
    EXPECT_FALSE(cache_.find(kKernels.take_samples, {}));
    EXPECT_EQ(cache_.specialized(kKernels.take_samples, {}), made);
    EXPECT_EQ(vulkan::read_cached(file), whole);
  }
  // The file of another module.
  cache_.specialized(kKernels.trace_rays, {});
  for (const std::filesystem::path& path : files()) std::ofstream(path, std::ios::binary) << whole;
  EXPECT_EQ(cache_.find(kKernels.take_samples, {}), made);
  EXPECT_FALSE(cache_.find(kKernels.trace_rays, {}));
}

TEST_F(ModuleCacheTest, KeepsTheLastOnes) {
  const auto constants = [](std::uint32_t i) { return std::vector<vulkan::Specialization>{{9999, i}}; };
  cache_.specialized(kKernels.take_samples, constants(0));
  for (std::uint32_t i = 1; i < 2 * vulkan::ModuleCache::kMost; ++i) {
    cache_.specialized(kKernels.take_samples, constants(i));
    EXPECT_TRUE(cache_.find(kKernels.take_samples, constants(0))) << "it was used a moment ago";
  }
  EXPECT_EQ(files().size(), vulkan::ModuleCache::kMost);
  EXPECT_FALSE(cache_.find(kKernels.take_samples, constants(1)));
}

TEST_F(ModuleCacheTest, WorksWithoutAFolder) {
  const vulkan::ModuleCache nowhere{{}}, forbidden{"/proc/self/nothing"};
  for (const vulkan::ModuleCache* cache : {&nowhere, &forbidden})
    EXPECT_EQ(cache->specialized(kKernels.take_samples, {}), specialize(kKernels.take_samples, {}));
}

}  // namespace
}  // namespace etendue
