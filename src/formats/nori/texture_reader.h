#pragma once
/// <texture> → tables of a scene.

#include <map>
#include <optional>
#include <set>
#include <string>

#include "formats/dialect/object.h"
#include "formats/nori/named_files.h"
#include "scene/scene.h"

namespace etendue {

/// Fills Scene::textures and Scene::bitmaps: an element with many references becomes one texture, and a file named many
/// times one picture.
class TextureReader {
 public:
  TextureReader(ReadContext& context, NamedFiles& files) : context_(context), files_(files) {}

  /// Forgets the textures of another scene.
  void begin_scene() {
    textures_.clear();
    factors_.clear();
    channels_.clear();
    constants_.clear();
    bitmaps_.clear();
  }

  /// The texture of a property of the object; nothing if there is none, or if it is unusable, which is reported.
  std::optional<std::uint32_t> read(const Object& owner, const char* property, Scene& scene);
  /// The colour of a texture that is the same everywhere, once it has been read: it is no row of the scene, and needs
  /// no texture coordinates.
  std::optional<glm::dvec3> constant(const Object& owner, const char* property) const;
  /// The factor of that texture, once it has been read.
  glm::dvec3 factor(const Object& owner, const char* property) const;
  /// The channel of a texture to use as a number, once it has been read.
  TextureChannel channel_of(const Object& owner, const char* property) const {
    return channels_.at(owner.child_of(property));
  }

 private:
  std::optional<Texture> read_texture(const Object& object, Scene& scene);
  /// The colour of a checkerboard's squares, and the texture in them.
  void read_square(const Object& board, const char* property, Scene& scene, glm::dvec3& color,
                   std::optional<std::uint32_t>& row);
  std::optional<Texture> read_bitmap_texture(const Object& object, Scene& scene);
  std::optional<std::uint32_t> read_picture(const Object& object, Texture& texture, Scene& scene);
  TextureChannel read_channel(const Object& object);
  void set_wrap(const Object& object, BitmapTexture& picture);
  void set_filter(const Object& object, BitmapTexture& picture);

  ReadContext& context_;
  NamedFiles& files_;
  std::map<const XmlElement*, std::optional<std::uint32_t>> textures_;
  std::set<const XmlElement*> open_;                 ///< being read
  std::map<const XmlElement*, glm::dvec3> factors_;  ///< other than 1
  std::map<const XmlElement*, TextureChannel> channels_;
  std::map<const XmlElement*, glm::dvec3> constants_;
  std::map<std::string, std::optional<std::uint32_t>> bitmaps_;  ///< by path
};

}  // namespace etendue
