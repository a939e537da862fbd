#pragma once
/// The lamps (KHR_lights_punctual) and the cameras of a glTF asset.

#include <optional>
#include <string>

#include "formats/gltf/gltf_document.h"
#include "formats/read_options.h"
#include "scene/scene.h"

namespace etendue {

/// How the numbers of lamps are read. One candela or lux in the file is 1 here, like one cd/m² of an emissive surface.
/// Blender multiplies the watts of its lamps by 683 on export, but not the emission of surfaces. In files that name
/// Blender as their generator, lamps are therefore divided by 683. Its spots fade as in Blender, whatever their unit.
struct LampRule {
  double unit = 1.0;       ///< intensities are divided by this
  double unit_bulb = 1.0;  ///< those of points and spots also by this
  bool fades_as_blender = false;
};
LampRule lamp_rule(const JsonValue& root, GltfLamps lamps);

/// The lamp that `reference` of a node names. Throws GltfError.
DeltaLight gltf_light(const GltfDocument& document, const JsonValue& reference, const glm::dmat4& world_from_node,
                      const LampRule& rule);

/// Sets `camera` to the camera of a node, but keeps its film and filter. Throws GltfError.
void set_gltf_camera(const JsonValue& json, const glm::dmat4& world_from_node, Camera& camera);

}  // namespace etendue
