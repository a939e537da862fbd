#pragma once
/// Evaluates the animations of a glTF asset at one time (docs/gltf.md, "Animations").

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/gltf/accessors.h"
#include "scene/diagnostics.h"

namespace etendue {

/// The animated properties of a node; the others keep the node's own values.
struct GltfNodePose {
  std::optional<glm::dvec3> translation, scale;
  std::optional<glm::dvec4> rotation;  ///< (x, y, z, w)
  std::optional<std::vector<double>> weights;
};

struct GltfPose {
  std::map<std::uint32_t, GltfNodePose> nodes;
  double end = 0.0;  ///< seconds; nothing moves after this time
};

/// Evaluates all animations, or only that with the given number, at a time in seconds. Before its first and after its
/// last keyframe a channel keeps its value. If two animations move the same property of a node, the first one counts,
/// and there is a warning. Throws GltfError for damaged animations: keyframe times that are not finite or do not
/// increase, tables of the wrong length, values that are not finite, nodes that do not exist or have a matrix.
GltfPose gltf_pose(const GltfDocument& document, Accessors& accessors, double time,
                   std::optional<std::uint32_t> animation, Diagnostics& diagnostics);

}  // namespace etendue
