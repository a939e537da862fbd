#pragma once
/// Writes scenes for Mitsuba 3.

#include <string>
#include <vector>

#include "formats/dialect/scene_files.h"

namespace etendue {

/// Writes the scene to `path`, and the files that it needs into the folder NAME-files next to it. Returns sentences
/// about what Mitsuba will render differently. Throws Error(file), and Error(scene) for what Mitsuba does not support;
/// then nothing is left behind.
std::vector<std::string> write_mitsuba_scene(const std::string& path, const Scene& scene,
                                             ExistingFiles existing = ExistingFiles::refuse);

/// Only the <sensor> element, to be pasted into a scene file. Throws Error(scene) for what Mitsuba does not support.
std::string sensor_element(const Camera& camera, const Sampler& sampler);

/// The <bsdf> element for a row of the scene's materials, after those that it refers to. Only materials, textures and
/// pictures of the scene are used. Throws Error(scene) for what Mitsuba does not support.
std::string mitsuba_bsdf_element(const Scene& scene, std::uint32_t row);

}  // namespace etendue
