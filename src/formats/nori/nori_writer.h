#pragma once
/// Scenes as files of Etendue's own dialect.

#include <string>

#include "formats/dialect/scene_files.h"

namespace etendue {

/// Writes the scene to `path`, and what it needs into the folder NAME-files beside it; reading it gives a scene that
/// renders to the same film, byte for byte on one device. Throws Error(scene) for what no file can say, Error(file);
/// then nothing is left behind.
void write_scene(const std::string& path, const Scene& scene, ExistingFiles existing = ExistingFiles::refuse);

/// The <camera> element alone, to be pasted into a scene file. Throws Error(scene) for what no file can say.
std::string camera_element(const Camera& camera);

/// The <bsdf> element of a row of the scene's materials, behind those that it refers to. Of the scene only materials,
/// textures and pictures are looked at. Throws Error(scene) for what no file can say.
std::string bsdf_element(const Scene& scene, std::uint32_t row);

}  // namespace etendue
