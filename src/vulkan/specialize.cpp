#include "vulkan/specialize.h"

#include <string>
#include <unordered_map>

#include <fmt/core.h>
#include <spirv-tools/optimizer.hpp>

#include "core/errors.h"

namespace etendue::vulkan {

std::vector<std::uint32_t> specialize(std::span<const std::uint32_t> spirv, std::span<const Specialization> constants) {
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> values;
  for (const Specialization& c : constants) values[c.id] = {c.value};
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_2);
  std::string complaint;
  optimizer.SetMessageConsumer(
      [&](spv_message_level_t, const char*, const spv_position_t&, const char* message) { complaint = message; });
  // Inlining would remove more code, but take more time than the driver then saves.
  optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
      .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterPass(spvtools::CreateLocalSingleStoreElimPass())
      .RegisterPass(spvtools::CreateCCPPass())
      .RegisterPass(spvtools::CreateDeadBranchElimPass())
      .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
      .RegisterPass(spvtools::CreateAggressiveDCEPass());
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);  // builds with tests have validated it
  std::vector<std::uint32_t> out;
  if (!optimizer.Run(spirv.data(), spirv.size(), &out, options))
    throw Error(ErrorKind::bug, fmt::format("A kernel cannot be specialized: {}.", complaint));
  return out;
}

}  // namespace etendue::vulkan
