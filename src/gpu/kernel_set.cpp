#include "gpu/kernel_set.h"

#include "kernels.h"
#include "kernels_mutant.h"
#include "kernels_profile.h"
#include "kernels_profile_storage.h"
#include "kernels_profile_subgroups.h"
#include "kernels_profile_subgroups_storage.h"
#include "kernels_storage.h"
#include "mutants.h"

namespace etendue {

KernelSet kernel_set(std::optional<std::uint32_t> mutant, TableLoads loads) {
  if (!mutant && loads == TableLoads::storage_buffer)
    return {kernels::render_storage,
            kernels::trace_samples_storage,
            kernels::trace_path_storage,
            kernels::trace_rays_storage,
            kernels::bsdf_samples_storage,
            kernels::render_profile_storage,
            kernels::render_profile_subgroups_storage,
            {}};
  if (!mutant)
    return {kernels::render,
            kernels::trace_samples,
            kernels::trace_path,
            kernels::trace_rays,
            kernels::bsdf_samples,
            kernels::render_profile,
            kernels::render_profile_subgroups,
            {}};
  // Errors are planted to be found in pictures, not in counts.
  return {kernels::render_mutant,
          kernels::trace_samples_mutant,
          kernels::trace_path_mutant,
          kernels::trace_rays_mutant,
          kernels::bsdf_samples_mutant,
          kernels::render_profile,
          kernels::render_profile_subgroups,
          {{gpu::kConstantMutant, *mutant}}};
}

}  // namespace etendue
