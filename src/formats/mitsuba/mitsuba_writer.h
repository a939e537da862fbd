#pragma once
/// Scenes as files for Mitsuba 3.

#include <string>
#include <vector>

#include "formats/dialect/scene_files.h"

namespace etendue {

/// Writes the scene to `path`, and what it needs into the folder NAME-files beside it. Returns sentences on what
/// Mitsuba will render differently. Throws Error(scene) for what it does not have, Error(file); then nothing is left
/// behind.
std::vector<std::string> write_mitsuba_scene(const std::string& path, const Scene& scene,
                                             ExistingFiles existing = ExistingFiles::refuse);

/// The <sensor> element alone, to be pasted into a scene file. Throws Error(scene) for what Mitsuba does not have.
std::string sensor_element(const Camera& camera, const Sampler& sampler);

}  // namespace etendue
