/// The kernels that render pictures hold no planted errors; those of `etendue-mutate` do.

#include <algorithm>
#include <cstdint>
#include <span>

#include <gtest/gtest.h>

#include "mutants.h"
#include "mutants/mutate.h"

namespace etendue {
namespace {

/// True when the module decorates anything with SpecId `id` (SPIR-V 1.5, §3.20 and OpDecorate).
bool has_constant(std::span<const std::uint32_t> spirv, std::uint32_t id) {
  constexpr std::size_t kHeaderWords = 5;
  constexpr std::uint32_t kOpDecorate = 71, kSpecId = 1;
  for (std::size_t i = kHeaderWords; i < spirv.size(); i += std::max(1u, spirv[i] >> 16)) {
    if ((spirv[i] & 0xffffu) == kOpDecorate && spirv[i + 2] == kSpecId && spirv[i + 3] == id) return true;
  }
  return false;
}

TEST(Mutants, ReleaseKernelsHoldNone) {
  const KernelSet release = kernel_set(TableLoads::texel_buffer);
  const KernelSet wrong = kernels_with(gpu::kMutantNone);
  for (const auto kernel : {release.render, release.trace_samples, release.trace_path, release.bsdf_samples}) {
    EXPECT_FALSE(kernel.empty());
    EXPECT_FALSE(has_constant(kernel, gpu::kConstantMutant));
  }
  for (const auto kernel : {wrong.render, wrong.trace_samples, wrong.trace_path, wrong.bsdf_samples})
    EXPECT_TRUE(has_constant(kernel, gpu::kConstantMutant));
  EXPECT_TRUE(release.constants.empty());
}

TEST(Mutants, NamesAreUniqueAndNumbersDense) {
  const auto all = mutants();
  ASSERT_EQ(all.size(), gpu::kMutantCount);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].id, i);
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(all[i].name, all[j].name);
  }
}

TEST(Mutants, UnknownNumbersAreErrors) {
  MutateOptions options;
  options.only = {gpu::kMutantCount};
  EXPECT_THROW(run_mutate(options), std::runtime_error);
}

}  // namespace
}  // namespace etendue
