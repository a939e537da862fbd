#include "image/film.h"

#include <algorithm>
#include <bit>
#include <limits>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/wide_uint.h"

namespace etendue {
namespace {

/// One sample component in film units: sign and |q| < 2^80.
struct Quantised {
  Uint128 magnitude = 0;
  bool negative = false;
};

/// q = trunc(v · 2^(56 − exponent)) from the bits of v, so that every machine gets the same integer. Returns false for
/// values that the film rejects: NaN, infinity, |v| >= 2^(exponent + 24).
bool quantise(float v, int exponent, Quantised& q) {
  const auto bits = std::bit_cast<std::uint32_t>(v);
  const int field = static_cast<int>(bits >> 23 & 0xffu);
  if (field == 0xff) return false;
  const std::uint32_t mantissa = (bits & 0x7fffffu) | (field != 0 ? 0x800000u : 0u);
  q.negative = (bits >> 31) != 0;
  q.magnitude = 0;
  if (mantissa == 0) return true;
  // v = mantissa · 2^lowest.
  const int lowest = (field != 0 ? field : 1) - 150;
  if (bit_width(std::uint64_t{mantissa}) - 1 + lowest >= exponent + 24) return false;
  const int shift = lowest + 56 - exponent;
  if (shift >= 0) {
    q.magnitude = static_cast<Uint128>(mantissa) << shift;
  } else if (shift > -24) {
    q.magnitude = mantissa >> -shift;
  }
  return true;
}

Uint128 load_sum(const std::array<std::uint32_t, 4>& limbs) {
  const std::uint64_t low = static_cast<std::uint64_t>(limbs[1]) << 32 | limbs[0];
  const std::uint64_t high = static_cast<std::uint64_t>(limbs[3]) << 32 | limbs[2];
  return static_cast<Uint128>(high) << 64 | low;
}

void store_sum(std::array<std::uint32_t, 4>& limbs, Uint128 value) {
  for (int i = 0; i < 4; ++i) limbs[i] = static_cast<std::uint32_t>(value >> (32 * i));
}

using Squares = WideUint<3>;

Squares load_squares(const std::array<std::uint32_t, 6>& limbs) {
  Squares value;
  for (std::size_t i = 0; i < 3; ++i) value.limb[i] = static_cast<std::uint64_t>(limbs[2 * i + 1]) << 32 | limbs[2 * i];
  return value;
}

void store_squares(std::array<std::uint32_t, 6>& limbs, const Squares& value) {
  for (int i = 0; i < 6; ++i) limbs[i] = static_cast<std::uint32_t>(value.limb[i / 2] >> (32 * (i % 2)));
}

/// |two's complement value|; sets `negative`.
Uint128 magnitude(Uint128 value, bool& negative) {
  negative = (value >> 127) != 0;
  return negative ? ~value + 1 : value;
}

template <int N>
WideUint<N> widen(Uint128 value) {
  WideUint<N> wide;
  wide.limb[0] = static_cast<std::uint64_t>(value);
  wide.limb[1] = static_cast<std::uint64_t>(value >> 64);
  return wide;
}

template <int N>
WideUint<N> widen(const Squares& value) {
  WideUint<N> wide;
  std::copy(value.limb.begin(), value.limb.end(), wide.limb.begin());
  return wide;
}

/// n Σq² − (Σq)² = n (n − 1) times the sample variance. Never negative for sums of real samples (Cauchy–Schwarz).
template <int N>
WideUint<N> scatter(const WideUint<N>& sum, const WideUint<N>& squares, std::uint64_t n) {
  WideUint<N> result = squares * widen<N>(static_cast<Uint128>(n));
  result -= sum * sum;
  return result;
}

// Unit of the film: sums count multiples of 2^(exponent − 56), squares of its square.
int unit_exponent(int exponent) {
  return exponent - 56;
}

template <typename T, int N>
T mean_of(const WideUint<N>& sum, bool negative, std::uint64_t n, int exponent) {
  if (n == 0) return T(0);
  const T mean = round_to<T>(divide_truncated(sum, {n}, 120), unit_exponent(exponent));
  return negative ? -mean : mean;
}

template <int N>
Moments moments_of(const WideUint<N>& sum, bool negative, const WideUint<N>& squares, std::uint64_t n, int exponent) {
  Moments result;
  result.n = n;
  result.mean = mean_of<long double>(sum, negative, n, exponent);
  if (n < 2) return result;
  const Truncated variance = divide_truncated(scatter(sum, squares, n), {n, n - 1}, 120);
  result.variance = round_to<long double>(variance, 2 * unit_exponent(exponent));
  return result;
}

/// sqrt(scatter / (n² (n − 1))) in float32, rounded once: 62 bits of the quotient give 31 of the root.
float standard_error_of(const FilmPixel& pixel, int channel, int exponent) {
  if (pixel.count < 2) return std::numeric_limits<float>::infinity();
  const std::uint64_t n = pixel.count;
  bool negative;
  const auto sum = widen<4>(magnitude(load_sum(pixel.sum[channel]), negative));
  const auto squares = widen<4>(load_squares(pixel.sum_squares[channel]));
  const Truncated quotient = divide_truncated(scatter(sum, squares, n), {n * n, n - 1}, 62);
  return round_to<float>(sqrt_truncated(quotient), unit_exponent(exponent));
}

}  // namespace

void FilmPixel::add(const glm::vec3& rgb, int exponent) {
  std::array<Quantised, 3> q;
  for (int c = 0; c < 3; ++c) {
    if (!quantise(rgb[c], exponent, q[c])) {
      ++rejected;
      return;
    }
  }
  ++count;
  for (int c = 0; c < 3; ++c) {
    const Uint128 before = load_sum(sum[c]);
    store_sum(sum[c], q[c].negative ? before - q[c].magnitude : before + q[c].magnitude);
    const auto wide = widen<3>(q[c].magnitude);
    Squares squares = load_squares(sum_squares[c]);
    squares += wide * wide;
    store_squares(sum_squares[c], squares);
  }
}

void FilmPixel::merge(const FilmPixel& other) {
  for (int c = 0; c < 3; ++c) {
    store_sum(sum[c], load_sum(sum[c]) + load_sum(other.sum[c]));
    Squares squares = load_squares(sum_squares[c]);
    squares += load_squares(other.sum_squares[c]);
    store_squares(sum_squares[c], squares);
  }
  count += other.count;
  rejected += other.rejected;
}

Film::Film(std::uint32_t width, std::uint32_t height, int exponent)
    : width_(width), height_(height), exponent_(exponent), pixels_(static_cast<std::size_t>(width) * height) {}

void Film::merge(const Film& other) {
  if (other.width_ != width_ || other.height_ != height_) {
    throw Error(ErrorKind::usage,
                fmt::format("cannot merge a film of {}x{} pixels into one of {}x{}; sizes must be equal", other.width_,
                            other.height_, width_, height_));
  }
  if (other.exponent_ != exponent_) {
    throw Error(ErrorKind::usage,
                fmt::format("cannot merge a film with exponent {} into one with exponent {}; both must "
                            "come from the same scene",
                            other.exponent_, exponent_));
  }
  for (std::size_t i = 0; i < pixels_.size(); ++i) pixels_[i].merge(other.pixels_[i]);
}

glm::vec3 Film::mean(std::size_t pixel) const {
  const FilmPixel& p = pixels_[pixel];
  glm::vec3 result;
  for (int c = 0; c < 3; ++c) {
    bool negative;
    const auto sum = widen<4>(magnitude(load_sum(p.sum[c]), negative));
    result[c] = mean_of<float>(sum, negative, p.count, exponent_);
  }
  return result;
}

glm::vec3 Film::standard_error(std::size_t pixel) const {
  glm::vec3 result;
  for (int c = 0; c < 3; ++c) result[c] = standard_error_of(pixels_[pixel], c, exponent_);
  return result;
}

std::uint64_t Film::rejected() const {
  std::uint64_t total = 0;
  for (const FilmPixel& pixel : pixels_) total += pixel.rejected;
  return total;
}

Moments moments(const FilmPixel& pixel, int channel, int exponent) {
  bool negative;
  const auto sum = widen<4>(magnitude(load_sum(pixel.sum[channel]), negative));
  return moments_of(sum, negative, widen<4>(load_squares(pixel.sum_squares[channel])), pixel.count, exponent);
}

Moments film_moments(const Film& film, int channel) {
  // Up to 2^32 pixels of 2^32 samples: n < 2^64, |Σq| < 2^144, Σq² < 2^224, n Σq² < 2^288.
  using Wide = WideUint<5>;
  Wide positive, negative, squares;
  std::uint64_t n = 0;
  for (const FilmPixel& pixel : film.pixels()) {
    bool below_zero;
    const auto sum = widen<5>(magnitude(load_sum(pixel.sum[channel]), below_zero));
    (below_zero ? negative : positive) += sum;
    squares += widen<5>(load_squares(pixel.sum_squares[channel]));
    n += pixel.count;
  }
  Wide sum = positive;
  sum -= negative;
  const bool below_zero = (sum.limb[4] >> 63) != 0;
  if (below_zero) {
    sum = negative;
    sum -= positive;
  }
  return moments_of(sum, below_zero, squares, n, film.exponent());
}

}  // namespace etendue
