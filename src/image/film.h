#pragma once
/// Exact, order-free accumulation of samples: integers add associatively, so tiles, passes, shards and resumed renders
/// give the same bytes. The number format is derived in docs/conventions.md ("Film").

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

/// Integer sums of one pixel. Limbs are little-endian 32-bit words. The device writes the same 128 bytes.
struct FilmPixel {
  std::array<std::array<std::uint32_t, 4>, 3> sum{};          ///< Σq per channel, 128-bit two's complement
  std::array<std::array<std::uint32_t, 6>, 3> sum_squares{};  ///< Σq² per channel, 192-bit unsigned
  std::uint32_t count = 0;                                    ///< accepted samples
  std::uint32_t rejected = 0;                                 ///< NaN, infinite or out-of-range samples

  /// Adds one sample. Rejects (and counts) it if any component is NaN, infinite or >= 2^(exponent+24) in magnitude.
  void add(const glm::vec3& rgb, int exponent);
  /// Adds all samples of another pixel that has the same exponent.
  void merge(const FilmPixel& other);
  bool operator==(const FilmPixel&) const = default;
};
static_assert(sizeof(FilmPixel) == 128);

class Film {
 public:
  Film() = default;
  Film(std::uint32_t width, std::uint32_t height, int exponent);

  std::uint32_t width() const { return width_; }
  std::uint32_t height() const { return height_; }
  int exponent() const { return exponent_; }
  std::vector<FilmPixel>& pixels() { return pixels_; }  ///< row-major, top row first
  const std::vector<FilmPixel>& pixels() const { return pixels_; }

  /// Adds another film of the same size and exponent; throws Error(usage) when they differ.
  void merge(const Film& other);

  /// Mean per pixel, rounded once to float32; 0 where there are no samples.
  glm::vec3 mean(std::size_t pixel) const;
  /// Standard error of the mean per pixel; infinity with fewer than two samples.
  glm::vec3 standard_error(std::size_t pixel) const;
  std::uint64_t rejected() const;

 private:
  std::uint32_t width_ = 0, height_ = 0;
  int exponent_ = 0;
  std::vector<FilmPixel> pixels_;
};

/// Mean and unbiased sample variance of the values behind one channel's sums, as long double from exact integers.
struct Moments {
  long double mean = 0;
  long double variance = 0;  ///< 0 when n < 2
  std::uint64_t n = 0;
};
Moments moments(const FilmPixel& pixel, int channel, int exponent);
/// The same over every sample of the film (the whole film as one population).
Moments film_moments(const Film& film, int channel);

}  // namespace etendue
