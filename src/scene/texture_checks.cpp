#include "scene/texture_checks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/text.h"
#include "image/vectors.h"
#include "scene/limits.h"
#include "scene/materials.h"
#include "scene/parameters.h"
#include "scene/texture_facts.h"

namespace etendue {
namespace {

class TextureChecker {
 public:
  TextureChecker(const Scene& scene, Diagnostics& sink, const LocateField& locate)
      : scene_(scene), sink_(sink), locate_(locate) {}

  bool check() {
    const std::size_t errors = sink_.error_count();
    if (scene_.textures.size() > kMaxTextures)
      sink_.error(scene_.position, fmt::format("the scene has {} textures; at most {} are supported",
                                               scene_.textures.size(), kMaxTextures));
    for (const auto& bitmap : scene_.bitmaps) check_bitmap(bitmap.get());
    if (sink_.error_count() != errors) return false;
    depths_.assign(scene_.textures.size(), 0);
    for (const Texture& texture : scene_.textures) check_texture(texture);
    for (const Material& material : scene_.materials) {
      check_owner(material, material.position);
      if (material.adapter && sink_.error_count() == errors) check_map(material);
    }
    for (const AreaEmitter& emitter : scene_.emitters) check_owner(emitter, emitter.position);
    for (const DeltaLight& light : scene_.delta_lights) check_owner(light, light.position);
    if (sink_.error_count() != errors) return false;
    for (const Instance& instance : scene_.instances) check_instance(instance);
    if (sink_.error_count() != errors) return false;
    for (const Material& material : scene_.materials) check_values(material);
    for (const AreaEmitter& emitter : scene_.emitters) check_values(emitter.radiance, "radiance", emitter.position);
    for (const DeltaLight& light : scene_.delta_lights) {
      check_projected(light);
      check_values(light.intensity, "intensity", light.position);
    }
    return sink_.error_count() == errors;
  }

 private:
  void error(const SourcePosition& object, std::string_view field, std::string message) {
    const auto position = locate_ ? locate_(object, field) : std::nullopt;
    sink_.error(position.value_or(object), std::move(message));
  }

  void check_bitmap(const Bitmap* bitmap) {
    if (bitmap == nullptr) return sink_.error(scene_.position, "a picture of the scene is missing: a null pointer");
    const bool sound = bitmap->width >= 1 && bitmap->height >= 1 && bitmap->channels >= 1 && bitmap->channels <= 4 &&
                       bitmap->texels.size() == bitmap->row_bytes() * bitmap->height;
    if (sound) return;
    sink_.error(scene_.position,
                fmt::format("a picture of the scene has {} × {} texels of {} channels in {} bytes, which do not match",
                            bitmap->width, bitmap->height, bitmap->channels, bitmap->texels.size()));
  }

  void check_texture(const Texture& texture) {
    const std::string name = text::quoted(texture.name);
    const glm::dmat3& m = texture.uv_transform;
    bool usable = m[0][2] == 0.0 && m[1][2] == 0.0 && m[2][2] == 1.0;
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 2; ++row) usable = usable && std::abs(m[column][row]) <= kMaxTextureCoordinate;
    }
    if (!usable)
      error(texture.position, "uv_transform",
            fmt::format("the transform of the texture {} is not affine with entries up to {}", name,
                        kMaxTextureCoordinate));
    if (const auto* board = std::get_if<CheckerboardTexture>(&texture.source)) {
      if (!is_finite(board->color0) || !is_finite(board->color1))
        error(texture.position, "color0", fmt::format("a colour of the checkerboard {} is not finite", name));
      for (const auto& nested : {board->texture0, board->texture1}) {
        if (nested) check_nested(texture, *nested);
      }
    }
    if (texture.vertex_tint && std::holds_alternative<AttributeTexture>(texture.source))
      error(texture.position, "vertex_tint",
            fmt::format("the texture {} shows colours of a mesh, which are not multiplied with those of its vertices",
                        name));
    if (texture.alpha_cutoff && !std::isfinite(*texture.alpha_cutoff))
      error(texture.position, "alpha_cutoff", fmt::format("the cutoff of the texture {} is not finite", name));
    const auto* picture = std::get_if<BitmapTexture>(&texture.source);
    if (picture != nullptr && picture->bitmap >= scene_.bitmaps.size())
      sink_.error(texture.position, fmt::format("the texture {} refers to number {} of the scene's pictures, of which "
                                                "there are {}",
                                                name, picture->bitmap, scene_.bitmaps.size()));
  }

  /// Rows that come earlier cannot hold the checkerboard in their turn.
  void check_nested(const Texture& board, std::uint32_t row) {
    const std::string name = text::quoted(board.name);
    if (&board - scene_.textures.data() <= static_cast<std::ptrdiff_t>(row))
      return error(board.position, "color0",
                   fmt::format("the checkerboard {} holds number {} of the scene's textures, which is not among those "
                               "before it",
                               name, row));
    const Texture& nested = scene_.textures[row];
    std::uint32_t& depth = depths_[static_cast<std::size_t>(&board - scene_.textures.data())];
    depth = std::max(depth, depths_[row] + 1);
    if (depth > kMaxNestedTextures)
      error(board.position, "color0",
            fmt::format("in the checkerboard {} textures lie {} deep within each other; at most {} are supported", name,
                        depth, kMaxNestedTextures));
    if (std::holds_alternative<AttributeTexture>(nested.source) || nested.is_derived())
      error(board.position, "color0",
            fmt::format("the checkerboard {} holds the texture {}, which is no plain picture or checkerboard", name,
                        text::quoted(nested.name)));
    if (nested.uv_set != board.uv_set)
      error(board.position, "color0",
            fmt::format("the checkerboard {} lies by set {} of texture coordinates, and holds one of set {}", name,
                        board.uv_set, nested.uv_set));
  }

  template <typename Owner>
  void check_owner(const Owner& owner, const SourcePosition& position) {
    each_parameter(owner, [&](const char* field, const auto& parameter) {
      if (!parameter.texture || *parameter.texture < scene_.textures.size()) return;
      error(position, field,
            fmt::format("{} refers to number {} of the scene's textures, of which there are {}", field,
                        *parameter.texture, scene_.textures.size()));
    });
  }

  /// Maps that turn the normal: of a function of texture coordinates, and bumps of one whose slope is known.
  void check_map(const Material& material) {
    const auto* normals = std::get_if<NormalMapAdapter>(&*material.adapter);
    const auto* bumps = std::get_if<BumpMapAdapter>(&*material.adapter);
    if (normals != nullptr && normals->normals.texture &&
        std::holds_alternative<AttributeTexture>(scene_.textures[*normals->normals.texture].source))
      error(material.position, "normals", "the colours of a mesh are not a normal map; use a bitmap");
    if (bumps != nullptr && bumps->height.texture &&
        (!std::holds_alternative<BitmapTexture>(scene_.textures[*bumps->height.texture].source) ||
         scene_.textures[*bumps->height.texture].is_derived()))
      error(material.position, "height", "a bump map needs a texture with slopes; use a bitmap");
  }

  void check_instance(const Instance& instance) {
    const auto add = [&](const char* field, const auto& parameter) {
      if (parameter.texture) check_attributes(scene_.textures[*parameter.texture], field, instance);
    };
    each_material(scene_, instance.material, [&](const Material& material) {
      each_parameter(material, add);
      const auto* gltf = std::get_if<GltfBsdf>(&material.bsdf);
      if (!material.adapter && gltf != nullptr && gltf->coat_vertex_tangents && gltf->coat_normals.texture)
        check_tangents(instance);
      if (!material.adapter) return;
      const auto* normals = std::get_if<NormalMapAdapter>(&*material.adapter);
      if (normals != nullptr && normals->vertex_tangents) check_tangents(instance);
    });
    const AreaEmitter* emitter = scene_.emitter_of(instance);
    if (emitter == nullptr) return;
    each_parameter(*emitter, add);
    const Shape& shape = scene_.shape_of(instance);
    if (emitter->two_sided && !std::holds_alternative<TriangleMesh>(shape) && !std::holds_alternative<Disk>(shape))
      error(emitter->position, "two_sided",
            fmt::format("{} is neither a mesh nor a disk; only those can emit on both sides",
                        text::quoted(instance.name)));
  }

  /// Whether the shape has what the texture reads.
  void check_attributes(const Texture& texture, const char* field, const Instance& instance) {
    const auto lacks = [&](const std::string& what) {
      sink_.error(instance.position, fmt::format("{} has no {}, which its {} needs for the texture {}",
                                                 text::quoted(instance.name), what, field, text::quoted(texture.name)));
    };
    const auto* attribute = std::get_if<AttributeTexture>(&texture.source);
    const auto* mesh = std::get_if<TriangleMesh>(&scene_.shape_of(instance));
    const bool faces = attribute != nullptr && attribute->source == AttributeTexture::Source::face_color;
    if (mesh != nullptr && (texture.vertex_tint || (attribute != nullptr && !faces))) check_alphas(*mesh, instance);
    if (attribute != nullptr) {
      const char* what = faces ? "colours of faces" : "colours of vertices";
      if (mesh == nullptr || (faces ? mesh->face_colors : mesh->vertex_colors).empty()) return lacks(what);
      return check_colors(faces ? mesh->face_colors : mesh->vertex_colors, field, instance);
    }
    if (texture.vertex_tint) {
      if (mesh == nullptr || mesh->vertex_colors.empty()) return lacks("colours of vertices");
      check_colors(mesh->vertex_colors, field, instance);
    }
    // Spheres, disks and cylinders have one set.
    if (texture.uv_set >= (mesh == nullptr ? 1 : mesh->uv_sets.size()))
      return lacks(texture.uv_set == 0 ? "texture coordinates"
                                       : fmt::format("set {} of texture coordinates", texture.uv_set));
    if (mesh != nullptr) check_coordinates(*mesh, texture.uv_set, instance);
  }

  void check_coordinates(const TriangleMesh& mesh, std::uint32_t set, const Instance& instance) {
    if (!looked_at_.insert({instance.shape, set}).second) return;
    for (const glm::vec2& uv : mesh.uv_sets[set]) {
      if (std::abs(uv.x) <= kMaxTextureCoordinate && std::abs(uv.y) <= kMaxTextureCoordinate) continue;
      return sink_.error(instance.position,
                         fmt::format("{} has texture coordinates {} {}; up to {} are supported",
                                     text::quoted(instance.name), uv.x, uv.y, kMaxTextureCoordinate));
    }
  }

  void check_tangents(const Instance& instance) {
    const auto* mesh = std::get_if<TriangleMesh>(&scene_.shape_of(instance));
    if (mesh == nullptr || mesh->tangents.empty())
      return sink_.error(instance.position, fmt::format("{} has no tangents of vertices, which its normal map needs",
                                                        text::quoted(instance.name)));
    for (const glm::vec4& t : mesh->tangents) {
      if (std::isfinite(t.x + t.y + t.z + t.w)) continue;
      return sink_.error(instance.position, fmt::format("{} has a tangent {} {} {} {}; it must be finite",
                                                        text::quoted(instance.name), t.x, t.y, t.z, t.w));
    }
  }

  void check_alphas(const TriangleMesh& mesh, const Instance& instance) {
    for (const float alpha : mesh.vertex_alphas) {
      if (std::isfinite(alpha)) continue;
      return sink_.error(instance.position, fmt::format("{} has a vertex whose alpha is {}; it must be finite",
                                                        text::quoted(instance.name), alpha));
    }
  }

  void check_colors(const std::vector<glm::vec3>& colors, const char* field, const Instance& instance) {
    const bool light = std::string_view(field) == "radiance";
    for (const glm::vec3& color : colors) {
      const glm::dvec3 c(color);
      if (is_finite(c) && (!light || std::min({c.x, c.y, c.z}) >= 0.0)) continue;
      return sink_.error(instance.position, fmt::format("{} has a colour {} {} {}, which its {} cannot have",
                                                        text::quoted(instance.name), c.x, c.y, c.z, field));
    }
  }

  void check_values(const Material& material) {
    each_parameter(material, [&](const char* field, const auto& parameter) {
      if (!parameter.texture) return;
      const Texture& texture = scene_.textures[*parameter.texture];
      const auto* picture = std::get_if<BitmapTexture>(&texture.source);
      const auto* board = std::get_if<CheckerboardTexture>(&texture.source);
      // 8-bit codes cannot be anything else.
      if (picture != nullptr && scene_.bitmaps[picture->bitmap]->format == BitmapFormat::u8) return;
      if (picture == nullptr && (board == nullptr || !board->is_nested())) return;
      if (!texture_facts(scene_, texture).finite)
        error(material.position, field,
              fmt::format("the texture {} has texels that are not finite", text::quoted(texture.name)));
    });
  }

  /// A light has no mesh, so it cannot use mesh colours.
  void check_projected(const DeltaLight& light) {
    if (!light.intensity.texture) return;
    const Texture& texture = scene_.textures[*light.intensity.texture];
    if (texture.vertex_tint || std::holds_alternative<AttributeTexture>(texture.source))
      error(light.position, "intensity",
            fmt::format("the {} has no mesh whose colours the texture {} could show; use a picture",
                        text::quoted(light.name), text::quoted(texture.name)));
  }

  void check_values(const ColorParameter& light, const char* field, const SourcePosition& position) {
    if (!light.texture) return;
    const Texture& texture = scene_.textures[*light.texture];
    const TextureFacts facts = texture_facts(scene_, texture);
    const glm::dvec3 most = light.value * facts.largest;
    const double least = std::min({facts.least.x, facts.least.y, facts.least.z});
    const double largest = std::max({most.x, most.y, most.z});
    if (facts.finite && least >= 0.0 && largest <= kMaxRadiance) return;
    error(position, field,
          facts.finite ? fmt::format("with the texture {} the {} is {} to {}; use 0 to {}", text::quoted(texture.name),
                                     field, least, largest, kMaxRadiance)
                       : fmt::format("the texture {} has texels that are not finite", text::quoted(texture.name)));
  }

  const Scene& scene_;
  Diagnostics& sink_;
  const LocateField& locate_;
  std::vector<std::uint32_t> depths_;                            // of rows: checkerboards that lie within each other
  std::set<std::pair<std::uint32_t, std::uint32_t>> looked_at_;  // shapes and their sets
};

}  // namespace

bool check_textures(const Scene& scene, Diagnostics& diagnostics, const LocateField& locate) {
  return TextureChecker(scene, diagnostics, locate).check();
}

}  // namespace etendue
