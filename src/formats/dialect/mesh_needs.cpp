#include "formats/dialect/mesh_needs.h"

#include <algorithm>
#include <set>

#include "scene/materials.h"
#include "scene/parameters.h"

namespace etendue {

/// "weight" of the texture "face_weight"; colours have none.
std::string attribute_of(const Texture& texture) {
  for (const std::string_view prefix : {"vertex_", "face_"}) {
    if (!texture.name.starts_with(prefix)) continue;
    const std::string attribute = texture.name.substr(prefix.size());
    return attribute == "color" ? "" : attribute;
  }
  return "";
}

MeshContent content_for(std::uint32_t row, const AreaEmitter* emitter, const Scene& scene, bool shows_uv) {
  MeshContent content{.uv = false, .textured = false, .colors = false};
  std::set<std::string> attributes;
  const auto add = [&](const char*, const auto& parameter) {
    if (!parameter.texture) return;
    const Texture& texture = scene.textures[*parameter.texture];
    const bool colors = std::holds_alternative<AttributeTexture>(texture.source);
    (colors ? content.colors : content.textured) = true;
    content.colors |= texture.vertex_tint;
    if (colors) attributes.insert(attribute_of(texture));
  };
  each_material(scene, row, [&](const Material& material) {
    each_parameter(material, add);
    content.uv |= is_aligned(material);
    const auto* normals = material.adapter ? std::get_if<NormalMapAdapter>(&*material.adapter) : nullptr;
    content.tangents |= normals != nullptr && normals->vertex_tangents;
    const auto* gltf = material.adapter ? nullptr : std::get_if<GltfBsdf>(&material.bsdf);
    content.tangents |= gltf != nullptr && gltf->coat_vertex_tangents && gltf->coat_normals.texture;
  });
  if (emitter != nullptr) each_parameter(*emitter, add);
  content.uv |= content.textured || shows_uv || std::ranges::find(scene.aovs, Aov::uv) != scene.aovs.end();
  if (!attributes.empty()) content.attribute = *attributes.begin();
  content.attributes = attributes.size();
  return content;
}

}  // namespace etendue
