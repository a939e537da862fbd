#pragma once
/// What materials and emitters read of a mesh, beside its surface.

#include "formats/mesh/mesh_content.h"
#include "scene/scene.h"

namespace etendue {

/// Of the textures of a material and, where it is not null, of an emitter.
MeshContent content_for(const Bsdf& bsdf, const AreaEmitter* emitter, const Scene& scene);

}  // namespace etendue
