#pragma once
/// KHR_lights_punctual, and the cameras of a glTF asset.

#include <optional>
#include <string>

#include "formats/gltf/gltf_document.h"
#include "formats/read_options.h"
#include "scene/scene.h"

namespace etendue {

/// How the numbers of lamps are read. One candela or lux of the standard is 1 here, as one cd/m² of an emissive surface
/// is. Blender multiplies the watts of its lamps by 683 when it writes them, but not the emission of surfaces: of its
/// files, told by their generator, lamps are divided by that, and spots fade as they do there.
struct LampRule {
  double unit = 1.0;  ///< what intensities are divided by
  bool blender = false;
};
LampRule lamp_rule(const JsonValue& root, GltfLamps lamps);

/// The light of a node. Throws GltfError.
DeltaLight gltf_light(const GltfDocument& document, const JsonValue& reference, const glm::dmat4& world_from_node,
                      const LampRule& rule);

/// The camera of a node; film and filter as they are in `camera`. Throws GltfError.
void set_gltf_camera(const JsonValue& json, const glm::dmat4& world_from_node, Camera& camera);

}  // namespace etendue
