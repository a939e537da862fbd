#pragma once
/// Textures of a Mitsuba scene as rows of a Scene's tables.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>

#include "formats/mitsuba/mitsuba_files.h"
#include "formats/mitsuba/mitsuba_object.h"
#include "scene/scene.h"

namespace etendue {

/// Mitsuba's v counts from a picture's first row, that of a Scene from its last.
inline const glm::dmat3 kFlipV = {1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 1.0};

class MitsubaTextures {
 public:
  MitsubaTextures(const MitsubaContext& context, const MitsubaFiles& files, Scene& scene)
      : context_(context), files_(files), scene_(scene) {}

  /// A colour, or the texture that stands for it. What there is not here is grey and noted.
  ColorParameter parameter(const MitsubaColor& color);
  /// A number that a texture stands for: its luminance, or the channel that a bitmap names.
  ScalarParameter scalar(const XmlElement& texture);
  /// Where no texture can stand: grey in its place, which is noted with `of`, the name of the property.
  glm::dvec3 constant(const MitsubaColor& color, const char* of);
  /// The row of a new texture that is the same everywhere.
  std::uint32_t add_constant(const glm::dvec3& color, const SourcePosition& position);
  /// A picture by its name in the scene; null after reporting why not.
  std::shared_ptr<const Bitmap> picture(const MitsubaObject& object);

 private:
  /// A texture times a colour; the colour alone where there is no row.
  struct Scaled {
    glm::dvec3 factor{1.0};
    std::optional<std::uint32_t> row;
    TextureChannel channel = TextureChannel::luminance;  ///< where it stands for a number
  };
  /// `number`: it stands for one, not for a colour.
  Scaled scaled(const XmlElement& texture, bool number, int depth);
  Scaled read(const XmlElement& texture, bool number, int depth);
  std::optional<Texture> read_bitmap(const MitsubaObject& object);
  TextureChannel channel_of(const MitsubaObject& bitmap, bool number);
  Texture read_checkerboard(const MitsubaObject& object, bool number, int depth);
  void read_square(const MitsubaObject& board, const char* name, bool number, int depth, glm::dvec3& color,
                   std::optional<std::uint32_t>& row);
  std::optional<Texture> read_attribute(const MitsubaObject& object);
  /// What a picture is beyond its edges: as in a Scene, or black or white, where it gets a frame of such texels.
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
  std::map<std::string, std::shared_ptr<const Bitmap>> pictures_;  ///< by path; null where it cannot be read
  /// Their rows, by what frames them across and along.
  std::map<std::tuple<const Bitmap*, std::optional<double>, std::optional<double>>, std::uint32_t> bitmaps_;
};

}  // namespace etendue
