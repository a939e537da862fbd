#pragma once
/// What a preview shows, as a file: the one that `etendue render` would have written.

#include <string>
#include <vector>

#include "image/film.h"
#include "image/tone_mapping.h"
#include "scene/scene.h"

namespace etendue::view {

struct SnapshotFacts {
  const Scene& scene;
  const std::vector<Material>& materials;  ///< in place of the scene's, like the next two
  const Camera& camera;
  const Integrator& integrator;
  std::uint32_t seed;
  std::string device, driver;
  std::uint32_t samples;  ///< of the film: [0, samples)
};

/// The bytes of an .exr or .png file, whatever `extension` says; `display` is for .png. Throws Error(usage) for another
/// one, Error(file).
std::string snapshot_bytes(const SnapshotFacts& facts, const Film& film, const std::string& extension,
                           const Display& display);

}  // namespace etendue::view
