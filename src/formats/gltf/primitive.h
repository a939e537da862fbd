#pragma once
/// Reads a primitive of a glTF mesh as triangles, compressed or not, deformed by its morph targets and its skin.

#include <optional>
#include <vector>

#include "formats/gltf/accessors.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// What is needed of a primitive in addition to its surface.
struct PrimitiveNeeds {
  std::uint32_t uv_sets = 0;                ///< the first so many sets
  bool colors = false;                      ///< COLOR_0
  bool alphas = false;                      ///< the alpha of COLOR_0
  std::optional<std::uint32_t> tangent_uv;  ///< triangles with mirrored coordinates in this set go into a separate mesh
  std::optional<std::uint32_t> tangents;    ///< TANGENT, or if missing, tangents computed from this set
};

/// How a primitive is deformed.
struct PrimitivePose {
  std::vector<double> weights;     ///< of the morph targets
  std::vector<glm::dmat4> joints;  ///< world_from_bound of each; empty: no skin
};

/// The triangles of a primitive, in object space, or in world space if it has a skin. Texture coordinates have v
/// upward.
struct PrimitiveMeshes {
  TriangleMesh upright;
  TriangleMesh mirrored;  ///< empty unless `tangent_uv` asks for it
};

/// What a primitive has in addition to its surface.
struct PrimitiveContent {
  std::uint32_t uv_sets = 0;
  bool colors = false;  ///< other than white
  bool colors_have_alpha = false;
  bool normals = false;
};

PrimitiveContent primitive_content(const GltfDocument& document, Accessors& accessors, const JsonValue& primitive);
/// False for points and lines. Throws GltfError for an unknown mode.
bool has_triangles(const JsonValue& primitive);

/// Reads a primitive. Damaged triangles or values are left out, with a warning. Throws GltfError.
PrimitiveMeshes read_primitive(GltfDocument& document, Accessors& accessors, const JsonValue& primitive,
                               const PrimitiveNeeds& needs, const PrimitivePose& pose, Diagnostics& diagnostics);

}  // namespace etendue
