#include "formats/dialect/mesh_needs.h"

#include "scene/parameters.h"

namespace etendue {

MeshContent content_for(const Bsdf& bsdf, const AreaEmitter* emitter, const Scene& scene) {
  MeshContent content{.uv = false, .colors = false};
  const auto add = [&](const char*, const auto& parameter) {
    if (!parameter.texture) return;
    const bool colors = std::holds_alternative<AttributeTexture>(scene.textures[*parameter.texture].source);
    (colors ? content.colors : content.uv) = true;
  };
  each_parameter(bsdf, add);
  if (emitter != nullptr) each_parameter(*emitter, add);
  return content;
}

}  // namespace etendue
