#pragma once
/// A tin robot, the glTF asset of the gallery.

#include "sculpt/glb.h"

namespace etendue::sculpt {

/// A toy of lacquered tin, 2.6 high, that stands on a wooden board at y = 0 and faces +z, with toy blocks, a backdrop,
/// two lamps that are surfaces, and a camera. Materials have metal, clear coats, glowing parts, sheen and textures.
Glb robot();

}  // namespace etendue::sculpt
