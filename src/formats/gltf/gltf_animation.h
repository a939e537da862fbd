#pragma once
/// The animations of a glTF asset at one time: docs/gltf.md, "Animations".

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf/accessors.h"
#include "scene/diagnostics.h"

namespace etendue {

/// What animations say of a node; what they leave out is as the node has it.
struct GltfNodePose {
  std::optional<glm::dvec3> translation, scale;
  std::optional<glm::dvec4> rotation;  ///< (x, y, z, w)
  std::optional<std::vector<double>> weights;
};

struct GltfPose {
  std::map<std::uint32_t, GltfNodePose> nodes;
  double end = 0.0;  ///< seconds: behind it nothing moves
};

/// All animations, or the one of that number, at a time in seconds; before its first and behind its last keyframe a
/// channel stands still. Of two animations that move the same property of a node the first counts, with a warning.
/// Throws GltfError for what is damaged: keyframes whose times are no numbers or do not increase, tables of the wrong
/// length, values that are no numbers, nodes that there are not or that have a matrix.
GltfPose gltf_pose(const GltfDocument& document, Accessors& accessors, double time,
                   std::optional<std::uint32_t> animation, Diagnostics& diagnostics);

}  // namespace etendue
