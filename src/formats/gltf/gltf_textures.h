#pragma once
/// Turns textures and images of a glTF asset into textures and bitmaps of a scene.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "formats/gltf/accessors.h"
#include "formats/gltf/gltf_material.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// How to make a new picture from a texture's picture, texel by texel, for what a scene cannot express otherwise.
struct TextureRecipe {
  std::string key;  ///< equal for equal recipes
  std::function<Bitmap(const Bitmap&)> make;
};

class GltfTextures {
 public:
  GltfTextures(GltfDocument& document, Accessors& accessors, Scene& scene, Diagnostics& diagnostics, bool approximate)
      : document_(document), accessors_(accessors), scene_(scene), sink_(diagnostics), approximate_(approximate) {}

  /// A row of Scene::textures, or nothing after reporting why: as an error, or with `approximate` as a warning.
  std::optional<std::uint32_t> row(const GltfTextureInfo& info, ColorSpace color_space,
                                   const TextureRecipe* recipe = nullptr);
  /// That row, or white if there is none, multiplied by the vertex colours of the mesh.
  std::uint32_t tinted(std::optional<std::uint32_t> row, const SourcePosition& position);
  /// A copy of the row with these members set.
  std::uint32_t derived(std::uint32_t row, std::optional<double> alpha_cutoff, bool premultiplied);

 private:
  std::uint32_t once(const std::string& key, Texture texture);
  std::uint32_t make_row(const GltfTextureInfo& info, ColorSpace color_space, const TextureRecipe* recipe);
  std::uint32_t bitmap_of(std::uint32_t image, const TextureRecipe* recipe, const JsonValue& where);
  std::shared_ptr<const Bitmap> decoded(std::uint32_t image, const JsonValue& where);
  std::uint32_t image_of(const JsonValue& texture) const;

  GltfDocument& document_;
  Accessors& accessors_;
  Scene& scene_;
  Diagnostics& sink_;
  bool approximate_;
  std::map<std::string, std::optional<std::uint32_t>> rows_;
  std::map<std::string, std::uint32_t> derived_;
  std::map<std::string, std::uint32_t> bitmaps_;                  ///< by image and recipe's key
  std::map<std::uint32_t, std::weak_ptr<const Bitmap>> decoded_;  ///< by image
  std::set<std::string> said_;  ///< messages that have been reported, with their positions
};

TextureRecipe alpha_as_grey();
TextureRecipe white_with_alpha();
/// Tangent-space normals with x and y scaled; `flip` also negates y.
TextureRecipe scaled_normals(double scale, bool flip);
/// The colours multiplied by alpha, as sRGB.
TextureRecipe premultiplied();
/// Grey: from `least` where green is 0 to `most` where it is 1.
TextureRecipe film_thickness(double least, double most);
/// Grey: the roughness 1 − factor · alpha, for a glossiness in alpha.
TextureRecipe roughness_of_glossiness(double factor);

}  // namespace etendue
