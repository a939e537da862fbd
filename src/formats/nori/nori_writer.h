#pragma once
/// Scenes as files of Etendue's own dialect.

#include <string>

#include "formats/dialect/scene_files.h"

namespace etendue {

/// Writes the scene to `path`, and the files that it needs into the folder NAME-files next to it. Reading it gives a
/// scene that renders to the same film, byte for byte on one device. Throws Error(scene) for anything that a file
/// cannot express, and Error(file); then no files are left behind.
void write_scene(const std::string& path, const Scene& scene, ExistingFiles existing = ExistingFiles::refuse);

/// The <camera> element by itself, for use in a scene file. Throws Error(scene) for anything that a file cannot
/// express.
std::string camera_element(const Camera& camera);

/// The <bsdf> element of a row of the scene's materials, after those that it refers to. Only the scene's materials,
/// textures and pictures are used. Throws Error(scene) for anything that a file cannot express.
std::string bsdf_element(const Scene& scene, std::uint32_t row);

}  // namespace etendue
