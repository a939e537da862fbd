#pragma once
/// Everything a scene file of Nori's dialect can say, and what Etendue adds to it.

#include "formats/dialect/dialect.h"

namespace etendue {

const Dialect& nori_dialect();
/// The rows of lights without extent.
std::vector<Plugin> delta_light_plugins();
/// The rows of clear skies and their sun.
std::vector<Plugin> daylight_plugins();
/// The rows of materials.
std::vector<Plugin> bsdf_plugins();
/// The rows of textures.
std::vector<Plugin> texture_plugins();

}  // namespace etendue
