#pragma once

#include <string>

namespace etendue {

/// All of a scene file. Throws Error(file) when it cannot be read, Error(scene) when it is too large for one.
std::string read_scene_text(const std::string& path);

}  // namespace etendue
