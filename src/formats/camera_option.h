#pragma once
/// What --camera says: where a scene is seen from.

#include <string>

#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// Whether it is numbers, for eye and target; else it may be the name of a camera.
bool is_camera_placement(const std::string& text);

/// Puts the scene's camera there.
void set_camera(const std::string& text, Scene& scene, Diagnostics& diagnostics);

}  // namespace etendue
