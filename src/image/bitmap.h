#pragma once
/// Pictures used by scenes: textures and skies. Texels are kept as stored, so 8-bit data take one byte each.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace etendue {

/// The type of a stored number. Codes of 8 bits stand for code / 255; 16-bit codes of PNG become f32, code / 65535.
enum class BitmapFormat : std::uint8_t { u8, f16, f32 };

/// The meaning of a stored number in a colour channel. Alpha is always linear.
enum class ColorSpace : std::uint8_t {
  linear,  ///< Rec. 709 primaries, proportional to light
  srgb,    ///< encoded by the curve of IEC 61966-2-1
};

struct Bitmap {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 0;  ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  BitmapFormat format = BitmapFormat::f32;
  /// The usual one for the file type: sRGB for PNG, JPEG and WebP, linear for EXR and HDR. Users of the picture may
  /// override it: normals and roughness in a PNG are linear.
  ColorSpace color_space = ColorSpace::linear;
  std::vector<std::byte> texels;   ///< row-major, top row first, channels interleaved, little-endian, without gaps
  std::vector<std::string> notes;  ///< sentences about information in the file that is ignored; not part of the picture

  std::size_t row_bytes() const;
  bool has_alpha() const { return channels == 2 || channels == 4; }
  /// A number as stored, in [0,1] for 8 bits; the curve of sRGB is not undone.
  float stored(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const;
};

std::size_t bytes_of(BitmapFormat format);
/// Sets negative floats, which resampling leaves near bright edges, to 0; returns their number.
std::size_t clear_negative_values(Bitmap& bitmap);
/// Linear value of an sRGB code in [0,1], by IEC 61966-2-1.
double linear_from_srgb(double code);

struct BitmapOptions {
  /// The channels of EXR files are `layer.R` and so on; if `layer` is empty, those without a prefix, or of the only
  /// layer.
  std::string layer;
};

/// Reads PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR, by content. Throws Error(file) with the reason; sizes are
/// checked against the length of the file before memory is allocated.
Bitmap read_bitmap(const std::string& path, const BitmapOptions& options = {});

}  // namespace etendue
