#pragma once
/// Fixed-width unsigned integers for the film's exact statistics, and their one rounding to floating point.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>

namespace etendue {

__extension__ using Uint128 = unsigned __int128;

// Not std::bit_width: its return type changed between library versions (LWG 3656).
inline int bit_width(std::uint64_t value) {
  return 64 - std::countl_zero(value);
}
inline int bit_width(Uint128 value) {
  const auto high = static_cast<std::uint64_t>(value >> 64);
  return high != 0 ? 64 + bit_width(high) : bit_width(static_cast<std::uint64_t>(value));
}

/// Unsigned integer of N little-endian 64-bit limbs; arithmetic is modulo 2^(64 N).
template <int N>
struct WideUint {
  std::array<std::uint64_t, N> limb{};

  int width() const {
    for (int i = N - 1; i >= 0; --i) {
      if (limb[i] != 0) return 64 * i + bit_width(limb[i]);
    }
    return 0;
  }
  bool is_zero() const { return width() == 0; }

  WideUint& operator+=(const WideUint& other) {
    Uint128 carry = 0;
    for (int i = 0; i < N; ++i) {
      carry += static_cast<Uint128>(limb[i]) + other.limb[i];
      limb[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    return *this;
  }

  WideUint& operator-=(const WideUint& other) {
    std::uint64_t borrow = 0;
    for (int i = 0; i < N; ++i) {
      const Uint128 difference = static_cast<Uint128>(limb[i]) - other.limb[i] - borrow;
      limb[i] = static_cast<std::uint64_t>(difference);
      borrow = static_cast<std::uint64_t>(difference >> 64) != 0 ? 1 : 0;
    }
    return *this;
  }

  friend WideUint operator*(const WideUint& a, const WideUint& b) {
    WideUint product;
    for (int i = 0; i < N; ++i) {
      if (a.limb[i] == 0) continue;
      std::uint64_t carry = 0;
      for (int j = 0; i + j < N; ++j) {
        const Uint128 t = static_cast<Uint128>(a.limb[i]) * b.limb[j] + product.limb[i + j] + carry;
        product.limb[i + j] = static_cast<std::uint64_t>(t);
        carry = static_cast<std::uint64_t>(t >> 64);
      }
    }
    return product;
  }

  /// Divides by `divisor` and returns the remainder.
  std::uint64_t divide(std::uint64_t divisor) {
    std::uint64_t remainder = 0;
    for (int i = N - 1; i >= 0; --i) {
      if (remainder == 0 && limb[i] == 0) continue;
      const Uint128 dividend = (static_cast<Uint128>(remainder) << 64) | limb[i];
      limb[i] = static_cast<std::uint64_t>(dividend / divisor);
      remainder = static_cast<std::uint64_t>(dividend % divisor);
    }
    return remainder;
  }

  /// Multiplies by 2^bits (rounding down for negative `bits`); returns true if non-zero bits were lost at the lower
  /// end.
  bool scale(int bits) {
    const WideUint before = *this;
    const int words = (bits >= 0 ? bits : -bits) / 64;
    const int rest = (bits >= 0 ? bits : -bits) % 64;
    const auto at = [&](int i) { return i >= 0 && i < N ? before.limb[i] : std::uint64_t{0}; };
    for (int i = 0; i < N; ++i) {
      if (bits >= 0) {
        limb[i] = at(i - words) << rest | (rest != 0 ? at(i - words - 1) >> (64 - rest) : 0);
      } else {
        limb[i] = at(i + words) >> rest | (rest != 0 ? at(i + words + 1) << (64 - rest) : 0);
      }
    }
    if (bits >= 0) return false;
    bool lost = words < N && rest != 0 && (before.limb[words] << (64 - rest)) != 0;
    for (int i = 0; i < words && i < N; ++i) lost = lost || before.limb[i] != 0;
    return lost;
  }
};

/// A non-negative real x, known to lie in [digits, digits + 1) · 2^exponent; `exact` means at the left end.
struct Truncated {
  Uint128 digits = 0;
  int exponent = 0;
  bool exact = true;
};

/// numerator / Π divisors with between `bits` and `bits` + 1 + number of divisors significant bits and an even
/// exponent. Repeated flooring division by the factors is the flooring division by their product.
template <int N>
Truncated divide_truncated(WideUint<N> numerator, std::initializer_list<std::uint64_t> divisors, int bits) {
  if (numerator.is_zero()) return {};
  int shift = bits - numerator.width();
  for (const std::uint64_t divisor : divisors) shift += bit_width(divisor);
  shift += shift & 1;
  bool exact = !numerator.scale(shift);
  for (const std::uint64_t divisor : divisors) exact = (numerator.divide(divisor) == 0) && exact;
  return {static_cast<Uint128>(numerator.limb[1]) << 64 | numerator.limb[0], -shift, exact};
}

/// Square root of a value with at most 100 significant bits and an even exponent.
inline Truncated sqrt_truncated(const Truncated& x) {
  auto root = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(x.digits)));
  while (static_cast<Uint128>(root) * root > x.digits) --root;
  while (static_cast<Uint128>(root + 1) * (root + 1) <= x.digits) ++root;
  return {root, x.exponent / 2, x.exact && static_cast<Uint128>(root) * root == x.digits};
}

/// x · 2^scale rounded to nearest, ties to even, subnormals included: the only rounding there is. Needs at least two
/// more digits than T holds unless x is exact.
template <typename T>
T round_to(const Truncated& x, int scale) {
  using Limits = std::numeric_limits<T>;
  if (x.digits == 0) return T(0);
  const int width = bit_width(x.digits);
  const int exponent = x.exponent + scale;
  const int lowest = Limits::min_exponent - Limits::digits;  // exponent of the last place of subnormals
  const int dropped = std::max(width - Limits::digits, lowest - exponent);
  if (dropped <= 0) return std::ldexp(static_cast<T>(x.digits), exponent);
  if (dropped > width) return T(0);
  Uint128 kept = x.digits >> dropped;
  const Uint128 half = static_cast<Uint128>(1) << (dropped - 1);
  const Uint128 rest = x.digits & (half + (half - 1));
  const bool tie = rest == half && x.exact;
  if (tie ? (kept & 1) != 0 : rest >= half) ++kept;
  return std::ldexp(static_cast<T>(kept), exponent + dropped);
}

}  // namespace etendue
