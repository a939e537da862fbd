#pragma once
/// Which build of the kernels a renderer runs: the one that renders pictures, or the one with planted errors.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gpu/device_scene.h"

namespace etendue {

struct KernelSet {
  std::span<const std::uint32_t> render, trace_samples, trace_path, trace_rays, bsdf_samples;  ///< SPIR-V words
  std::span<const std::uint32_t> render_plain, trace_samples_plain;  ///< without the features of shaders/features.glsl
  std::span<const std::uint32_t> profile,
      profile_subgroups;                          ///< the render kernel that counts, see shaders/profile.glsl
  std::vector<vulkan::Specialization> constants;  ///< to be added to those of the scene
};

/// Whether a scene with these constants asks for none of the features that plain kernels lack.
bool is_plain(std::span<const vulkan::Specialization> constants);

/// Without a mutant the kernels that render pictures; with one those of shaders/mutants.h with that error (0: none),
/// which read texel buffers only.
KernelSet kernel_set(std::optional<std::uint32_t> mutant, TableLoads loads = TableLoads::texel_buffer);

}  // namespace etendue
