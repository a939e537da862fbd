#pragma once
/// Textures and images of a glTF asset as textures and bitmaps of a scene.

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

/// A picture made of another texel by texel, where the scene has no words for what glTF does with it.
struct TextureRecipe {
  std::string key;  ///< equal for equal recipes
  std::function<Bitmap(const Bitmap&)> make;
};

class GltfTextures {
 public:
  GltfTextures(GltfDocument& document, Accessors& accessors, Scene& scene, Diagnostics& diagnostics, bool approximate)
      : document_(document), accessors_(accessors), scene_(scene), sink_(diagnostics), approximate_(approximate) {}

  /// A row of Scene::textures. Nothing after reporting why there is none: an error, or with `approximate` a warning.
  std::optional<std::uint32_t> row(const GltfTextureInfo& info, ColorSpace color_space,
                                   const TextureRecipe* recipe = nullptr);
  /// That row, or without one white, times the colours of a mesh's vertices.
  std::uint32_t tinted(std::optional<std::uint32_t> row, const SourcePosition& position);
  /// A row with these members set.
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
  std::map<std::string, std::uint32_t> bitmaps_;                  ///< by image and recipe
  std::map<std::uint32_t, std::weak_ptr<const Bitmap>> decoded_;  ///< by image
  std::set<std::string> said_;                                    ///< what was reported, with its place
};

/// 0 where alpha, times a factor, is below the cutoff, else 1; grey.
TextureRecipe alpha_cut(double factor, double cutoff);
/// Tangent-space normals with x and y scaled; `flip` turns y around.
TextureRecipe scaled_normals(double scale, bool flip);
/// The colours times alpha, sRGB.
TextureRecipe premultiplied();
/// From `least` where green is 0 to `most` where it is 1; grey.
TextureRecipe film_thickness(double least, double most);
/// Roughness of a glossiness in alpha, times a factor: 1 − factor · alpha; grey.
TextureRecipe roughness_of_glossiness(double factor);

}  // namespace etendue
