#pragma once
/// Facts about a texture as a whole: the brightness of lamps that use it, and values that a scene must not contain.

#include <cstdint>
#include <map>
#include <vector>

#include "scene/scene.h"

namespace etendue {

/// Statistics of the linear colours of all its texels.
struct TextureFacts {
  glm::dvec3 mean{1.0};
  glm::dvec3 least{1.0};
  glm::dvec3 largest{1.0};
  bool finite = true;  ///< otherwise the others are those of the finite numbers
};

/// For a picture or a checkerboard; mesh colours depend on the mesh. Visits every texel.
TextureFacts texture_facts(const Scene& scene, const Texture& texture);

/// Those of the scene's textures, each found once: many lamps may show the same large picture.
class KnownTextureFacts {
 public:
  explicit KnownTextureFacts(const Scene& scene) : scene_(scene) {}
  const Scene& scene() const { return scene_; }
  const TextureFacts& of(std::uint32_t texture);

 private:
  const Scene& scene_;
  std::map<std::uint32_t, TextureFacts> known_;
};

/// Radiance of the primitives of an emitting instance, averaged so that it is positive wherever they shine: what lights
/// are chosen by. Of a picture it is the mean over all of the picture, as if its alpha were 1.
class EmitterRadiance {
 public:
  /// The instance of that scene has an emitter, and the scene outlives this.
  EmitterRadiance(KnownTextureFacts& facts, const Instance& instance);

  /// The same for all primitives.
  bool uniform() const { return colors_ == nullptr; }
  glm::dvec3 mean(std::size_t primitive = 0) const;
  /// The mean over all of the shape, by area in its own space.
  glm::dvec3 mean_of_all() const;
  /// Largest component anywhere.
  double largest() const;

 private:
  const TriangleMesh* colors_ = nullptr;  ///< the mesh whose colours the texture is, or is multiplied with
  AttributeTexture::Source source_ = AttributeTexture::Source::vertex_color;
  glm::dvec3 mean_{0.0};     ///< without those colours
  glm::dvec3 largest_{0.0};  ///< likewise
};

/// The intensity of a light without extent, its texture averaged over all of it; and the largest.
glm::dvec3 mean_intensity(const Scene& scene, const DeltaLight& light);
glm::dvec3 largest_intensity(const Scene& scene, const DeltaLight& light);

/// The colour of a texel with alpha, linear; 8-bit codes and floats alike.
glm::dvec4 texel_color(const Bitmap& bitmap, ColorSpace color_space, std::uint32_t x, std::uint32_t y);

}  // namespace etendue
