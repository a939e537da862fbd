#pragma once
/// Pictures as scenes use them: textures and skies. Texels stay as they were stored, so 8-bit data take one byte each.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace etendue {

/// What a stored number is. Codes of 8 bits stand for code / 255; 16-bit codes of PNG become f32, code / 65535.
enum class BitmapFormat : std::uint8_t { u8, f16, f32 };

/// What a stored number of a colour channel means. Alpha is linear always.
enum class ColorSpace : std::uint8_t {
  linear,  ///< Rec. 709 primaries, proportional to light
  srgb,    ///< coded by the curve of IEC 61966-2-1
};

struct Bitmap {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t channels = 0;  ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA
  BitmapFormat format = BitmapFormat::f32;
  /// As files of that kind usually mean it: sRGB for PNG, JPEG and WebP, linear for EXR and HDR. Whoever uses it may
  /// know better: normals and roughness in a PNG are linear.
  ColorSpace color_space = ColorSpace::linear;
  std::vector<std::byte> texels;   ///< row-major, top row first, channels interleaved, little-endian, without gaps
  std::vector<std::string> notes;  ///< sentences about what the file says and is not followed; not part of the picture

  std::size_t row_bytes() const;
  bool has_alpha() const { return channels == 2 || channels == 4; }
  /// A number as stored, in [0,1] for 8 bits; the curve of sRGB is not undone.
  float stored(std::uint32_t x, std::uint32_t y, std::uint32_t channel) const;
};

std::size_t bytes_of(BitmapFormat format);
/// Makes negative floats 0, as resampling leaves them beside bright edges; returns how many there were.
std::size_t clear_negative_values(Bitmap& bitmap);
/// Light of an sRGB code in [0,1], IEC 61966-2-1.
double linear_from_srgb(double code);

struct BitmapOptions {
  /// Channels of EXR files are those called `layer.R` and so on; empty: those without a prefix, or of the only layer.
  std::string layer;
};

/// Reads PNG, JPEG, WebP, BMP, OpenEXR or Radiance HDR, by content. Throws Error(file) with the reason; sizes are
/// held against the length of the file before memory is spent.
Bitmap read_bitmap(const std::string& path, const BitmapOptions& options = {});

}  // namespace etendue
