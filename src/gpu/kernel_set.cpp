#include "gpu/kernel_set.h"

#include <algorithm>
#include <iterator>

#include "kernels.h"
#include "kernels_plain.h"
#include "kernels_profile.h"
#include "kernels_profile_storage.h"
#include "kernels_profile_subgroups.h"
#include "kernels_profile_subgroups_storage.h"
#include "kernels_query.h"
#include "kernels_storage.h"

namespace etendue {

KernelSet kernel_set(TableLoads loads) {
  if (loads == TableLoads::storage_buffer)
    return {kernels::render_storage,
            kernels::take_samples,
            kernels::trace_samples_storage,
            kernels::trace_path_storage,
            kernels::trace_rays_storage,
            kernels::bsdf_samples_storage,
            kernels::render_storage,  // scenes that need these loads are large, so the start-up time does not matter
            kernels::trace_samples_storage,
            kernels::trace_path_storage,
            kernels::render_profile_storage,
            kernels::render_profile_subgroups_storage,
            {}};
  return {kernels::render,
          kernels::take_samples,
          kernels::trace_samples,
          kernels::trace_path,
          kernels::trace_rays,
          kernels::bsdf_samples,
          kernels::render_plain,
          kernels::trace_samples_plain,
          kernels::trace_path_plain,
          kernels::render_profile,
          kernels::render_profile_subgroups,
          {}};
}

// Without kernels for plain scenes, because ray queries are meant for scenes with expensive paths.
KernelSet query_kernel_set() {
  KernelSet set = kernel_set(TableLoads::texel_buffer);
  set.render = set.render_plain = kernels::render_query;
  set.trace_samples = set.trace_samples_plain = kernels::trace_samples_query;
  set.trace_path = set.trace_path_plain = kernels::trace_path_query;
  set.trace_rays = kernels::trace_rays_query;
  set.profile = set.profile_subgroups = {};
  return set;
}

KernelSet kernel_set(const GpuOptions& options, TableLoads loads) {
  if (options.queries() && !options.kernels) return query_kernel_set();
  return options.kernels ? *options.kernels : kernel_set(loads);
}

namespace {

// The bits of each constant that a plain kernel supports; a scene that sets any other bit cannot use it. Constants
// whose ids are missing here are supported without restriction.
struct PlainConstant {
  std::uint32_t id, bits;
};
constexpr PlainConstant kPlain[] = {
    {gpu::kConstantCamera, gpu::kCameraPinhole},
    {gpu::kConstantCameraWindow, 0},
    {gpu::kConstantCylinderLights, 0},
    {gpu::kConstantTwoSidedLights, 0},
    {gpu::kConstantLampParts, 0},
    {gpu::kConstantDeltaLights, 0},
    {gpu::kConstantDistantLights, 0},
    {gpu::kConstantTextureFeatures, 0},
    {gpu::kConstantTextureUses, 0},
    {gpu::kConstantIntegrator, gpu::kIntegratorPath},
    {gpu::kConstantHideEmitters, 0},
    {gpu::kConstantInwardSpheres, 0},
    {gpu::kConstantHideBackground, 0},
    {gpu::kConstantLightPart, gpu::kLightPartAll},
    {gpu::kConstantHasDisks, 0},
    {gpu::kConstantHasCylinders, 0},
    {gpu::kConstantFewDisks, 0},
    {gpu::kConstantFewCylinders, 0},
    {gpu::kConstantInstanced, 0},
    {gpu::kConstantAdapters, 0},
    {gpu::kConstantAdapterDepth, 0},
    {gpu::kConstantBsdfsUsed, 1u << gpu::kBsdfDiffuse | 1u << gpu::kBsdfMirror | 1u << gpu::kBsdfDielectric},
};
static_assert(gpu::kCameraPinhole == 0 && gpu::kIntegratorPath == 0 && gpu::kLightPartAll == 0);

bool asks_nothing(const vulkan::Specialization& c) {
  // The instances of the few primitives, which only kernels need that let light pass.
  if (c.id >= gpu::kConstantFew && (c.id - gpu::kConstantFew) % gpu::kFewWords == gpu::kFewFloats) return c.value == 0;
  if (c.id == gpu::kConstantEnvironment) return c.value != gpu::kEnvironmentPicture;
  const auto known = std::ranges::find(kPlain, c.id, &PlainConstant::id);
  return known == std::end(kPlain) || (c.value & ~known->bits) == 0;
}

}  // namespace

bool is_plain(std::span<const vulkan::Specialization> constants) {
  return std::ranges::all_of(constants, asks_nothing);
}

}  // namespace etendue
