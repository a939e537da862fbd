#pragma once
/// The data of a mesh that materials and emitters read, besides its surface.

#include <string>

#include "formats/mesh/mesh_content.h"
#include "scene/scene.h"

namespace etendue {

/// Of a texture that is an attribute of a mesh: which of its file's, "" for colours. Its name says so.
std::string attribute_of(const Texture& texture);
/// Of the textures of a material and, where it is not null, of an emitter; and of AOVs, which show texture coordinates:
/// those of the scene, or the caller's.
MeshContent content_for(std::uint32_t material, const AreaEmitter* emitter, const Scene& scene, bool shows_uv);

}  // namespace etendue
