#pragma once
/// Values that vary over a surface: textures, and the parameters of materials and emitters that may refer to them.
/// docs/conventions.md, "Textures", defines their value at a point.

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include <glm/glm.hpp>

#include "image/bitmap.h"
#include "scene/source_position.h"

namespace etendue {

/// How a picture continues outside [0,1).
enum class TextureWrap : std::uint32_t { repeat, mirror, clamp };
enum class TextureFilter : std::uint32_t { nearest, bilinear };

/// A picture. (0,0) is the lower left corner of its last row, (1,1) the upper right one of its first.
struct BitmapTexture {
  std::uint32_t bitmap = 0;  ///< index into Scene::bitmaps
  TextureWrap wrap_u = TextureWrap::repeat, wrap_v = TextureWrap::repeat;
  TextureFilter filter = TextureFilter::bilinear;
  std::optional<ColorSpace> color_space;  ///< instead of the bitmap's own
};
/// Squares of side 1/2: `color0` where floor(2u) + floor(2v) is even.
struct CheckerboardTexture {
  glm::dvec3 color0{0.4};
  glm::dvec3 color1{0.2};
  /// The textures in the squares, multiplied by their colours: earlier rows of Scene::textures, pictures or
  /// checkerboards of the same set of coordinates, each in its own place on the surface.
  std::optional<std::uint32_t> texture0{}, texture1{};

  bool is_nested() const { return texture0 || texture1; }
};
/// Colours stored with a mesh: vertex colours are interpolated, face colours are not.
struct AttributeTexture {
  enum class Source : std::uint32_t { vertex_color, face_color };
  Source source = Source::vertex_color;
};

/// A function of a surface point whose value is red, green, blue and alpha. Pictures with one channel are grey; without
/// alpha it is 1. Multiplications and alpha operations are applied in the order of the members.
struct Texture {
  std::variant<BitmapTexture, CheckerboardTexture, AttributeTexture> source;
  glm::dmat3 uv_transform{1.0};  ///< texture coordinates of the surface (u, v, 1) → those of the texture; affine
  std::uint32_t uv_set = 0;      ///< index of the mesh's texture coordinates
  bool vertex_tint = false;      ///< multiply with the colours and alpha of the mesh's vertices
  std::optional<double> alpha_cutoff{};  ///< alpha becomes 1 from this value on, 0 below it
  bool premultiplied = false;            ///< multiply the colours with alpha
  std::string name;                      ///< for messages: the file name of a picture, or the type
  SourcePosition position;

  /// Whether it has any of the above.
  bool is_derived() const { return vertex_tint || alpha_cutoff || premultiplied; }
};

/// How the values of a texture are turned into one number.
enum class TextureChannel : std::uint32_t { red, green, blue, alpha, luminance };

/// A colour: `value`, or `value` times a texture.
struct ColorParameter {
  glm::dvec3 value{0.0};
  std::optional<std::uint32_t> texture;  ///< index into Scene::textures

  ColorParameter() = default;
  ColorParameter(const glm::dvec3& constant) : value(constant) {}
  ColorParameter(double r, double g, double b) : value(r, g, b) {}
  ColorParameter(const glm::dvec3& factor, std::uint32_t of) : value(factor), texture(of) {}
};
/// A number: `value`, or `value` times one channel of a texture.
struct ScalarParameter {
  double value = 0.0;
  std::optional<std::uint32_t> texture;  ///< index into Scene::textures
  TextureChannel channel = TextureChannel::red;

  ScalarParameter() = default;
  ScalarParameter(double constant) : value(constant) {}
  ScalarParameter(double factor, std::uint32_t of, TextureChannel which) : value(factor), texture(of), channel(which) {}
};

}  // namespace etendue
