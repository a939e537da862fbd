#pragma once
/// Turns textures of a Mitsuba scene into rows of a Scene's tables.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "formats/mitsuba/mitsuba_files.h"
#include "formats/mitsuba/mitsuba_object.h"
#include "scene/scene.h"

namespace etendue {

/// v = 0 is at the first row of a picture in Mitsuba, at the last in a Scene.
inline const glm::dmat3 kFlipV = {1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 1.0};

class MitsubaTextures {
 public:
  MitsubaTextures(const MitsubaContext& context, const MitsubaFiles& files, Scene& scene)
      : context_(context), files_(files), scene_(scene) {}

  /// A colour or a texture. Unsupported textures become grey and are noted.
  ColorParameter parameter(const MitsubaColor& color);
  /// A texture used as a number: its luminance, or the channel that a bitmap names.
  ScalarParameter scalar(const XmlElement& texture);
  /// For properties that cannot be textures: a texture becomes grey, which is noted with `of`, the property's name.
  glm::dvec3 constant(const MitsubaColor& color, const char* of);
  /// Adds a texture that is the same everywhere, and returns its row.
  std::uint32_t add_constant(const glm::dvec3& color, const SourcePosition& position);
  /// The picture that an object names; null after reporting an error.
  std::shared_ptr<const Bitmap> picture(const MitsubaObject& object);

 private:
  /// A texture multiplied by a colour; if there is no row, just the colour.
  struct Scaled {
    glm::dvec3 factor{1.0};
    std::optional<std::uint32_t> row;
    TextureChannel channel = TextureChannel::luminance;  ///< if it is used as a number
  };
  /// `number`: the texture is used as a number, not as a colour.
  Scaled scaled(const XmlElement& texture, bool number, int depth);
  Scaled read(const XmlElement& texture, bool number, int depth);
  std::optional<Texture> read_bitmap(const MitsubaObject& object);
  TextureChannel channel_of(const MitsubaObject& bitmap, bool number);
  Texture read_checkerboard(const MitsubaObject& object, bool number, int depth);
  void read_square(const MitsubaObject& board, const char* name, bool number, int depth, glm::dvec3& color,
                   std::optional<std::uint32_t>& row);
  std::optional<Texture> read_attribute(const MitsubaObject& object);
  /// What a picture shows outside its edges: as in a Scene, or black or white, for which it gets a frame of such
  /// texels.
  struct Wrap {
    TextureWrap mode = TextureWrap::repeat;
    std::optional<double> border = {};
  };
  Wrap wrap(const MitsubaObject& object, const char* name);
  std::uint32_t row_of(const std::shared_ptr<const Bitmap>& bitmap, const Wrap& u, const Wrap& v);
  void set_filter(const MitsubaObject& object, BitmapTexture& picture);
  void set_encoding(const MitsubaObject& object, BitmapTexture& picture);
  glm::dmat3 uv_transform(const MitsubaObject& object);
  std::uint32_t add(Texture texture);

  const MitsubaContext& context_;
  const MitsubaFiles& files_;
  Scene& scene_;
  std::map<std::pair<const XmlElement*, bool>, Scaled> rows_;
  std::map<std::string, std::shared_ptr<const Bitmap>> pictures_;  ///< by path; null if it cannot be read
  /// Rows of bitmaps, by picture and by the values in their frames.
  std::map<std::tuple<const Bitmap*, std::optional<double>, std::optional<double>>, std::uint32_t> bitmaps_;
};

}  // namespace etendue
