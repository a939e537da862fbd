#pragma once
/// Writes what a preview shows to a file, the same as `etendue render` would have written.

#include <string>
#include <vector>

#include "image/film.h"
#include "image/tone_mapping.h"
#include "scene/light_sources.h"
#include "scene/scene.h"

namespace etendue::view {

struct SnapshotFacts {
  const Scene& scene;
  const std::vector<Material>& materials;  ///< replace those of the scene, as do the next three
  const LightSources& lights;
  const Camera& camera;
  const Integrator& integrator;
  std::uint32_t seed;
  std::string device, driver;
  std::uint32_t samples;  ///< the film holds the samples [0, samples)
};

/// The bytes of a file of the format named by `extension`, ".exr" or ".png"; `display` applies to .png. Throws
/// Error(usage) for other extensions, and Error(file).
std::string snapshot_bytes(const SnapshotFacts& facts, const Film& film, const std::string& extension,
                           const Display& display);

}  // namespace etendue::view
