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

/// The <bsdf> element of a row of the scene's materials, behind those that it refers to. Of the scene only materials,
/// textures and pictures are looked at. Throws Error(scene) for what Mitsuba does not have.
std::string mitsuba_bsdf_element(const Scene& scene, std::uint32_t row);

}  // namespace etendue
