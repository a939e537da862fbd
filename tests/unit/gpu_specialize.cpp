/// Modules whose constants are fixed before a driver sees them.

#include "vulkan/specialize.h"

#include <map>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/errors.h"
#include "gpu/kernel_set.h"
#include "gpu_types.h"

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

}  // namespace
}  // namespace etendue
