#pragma once
/// A primitive of a glTF mesh as triangles: compressed or not, bent by its morph targets and its skin at rest.

#include <optional>
#include <vector>

#include "formats/gltf/accessors.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// What of a primitive is wanted beside its surface.
struct PrimitiveNeeds {
  std::uint32_t uv_sets = 0;                ///< the first so many
  bool colors = false;                      ///< COLOR_0
  bool alphas = false;                      ///< and its alpha
  std::optional<std::uint32_t> tangent_uv;  ///< the triangles whose coordinates in this set are mirrored stand apart
  std::optional<std::uint32_t> tangents;    ///< TANGENT, or without it those that follow from this set
};

/// How a primitive is bent.
struct PrimitivePose {
  std::vector<double> weights;     ///< of the morph targets
  std::vector<glm::dmat4> joints;  ///< world_from_bound of each; empty: no skin
};

/// The triangles of a primitive, in object space or, with a skin, in the world. Texture coordinates have v upward.
struct PrimitiveMeshes {
  TriangleMesh upright;
  TriangleMesh mirrored;  ///< empty unless asked for
};

/// What a primitive has beside its surface.
struct PrimitiveContent {
  std::uint32_t uv_sets = 0;
  bool colors = false;  ///< other than white
  bool colors_have_alpha = false;
  bool normals = false;
};

PrimitiveContent primitive_content(const GltfDocument& document, Accessors& accessors, const JsonValue& primitive);
/// False for points and lines. Throws GltfError for a mode that there is not.
bool has_triangles(const JsonValue& primitive);

/// Reads it. What is damaged here and there is left out with a warning. Throws GltfError.
PrimitiveMeshes read_primitive(GltfDocument& document, Accessors& accessors, const JsonValue& primitive,
                               const PrimitiveNeeds& needs, const PrimitivePose& pose, Diagnostics& diagnostics);

}  // namespace etendue
