#include "reference/rng.h"

namespace etendue::reference {
namespace {

/// The mirror image of a word: its binary fraction read from the other end.
std::uint32_t mirrored(std::uint32_t word) {
  word = word >> 16 | word << 16;
  word = (word & 0xff00ff00u) >> 8 | (word & 0x00ff00ffu) << 8;
  word = (word & 0xf0f0f0f0u) >> 4 | (word & 0x0f0f0f0fu) << 4;
  word = (word & 0xccccccccu) >> 2 | (word & 0x33333333u) << 2;
  return (word & 0xaaaaaaaau) >> 1 | (word & 0x55555555u) << 1;
}

/// A primitive polynomial x^degree + … + 1 modulo 2, the coefficients in between as bits with the highest first, and
/// the first direction numbers [Joe2008].
struct Polynomial {
  unsigned degree;
  std::uint32_t coefficients;
  std::array<std::uint32_t, 3> first;
};

using Directions = std::array<std::uint32_t, 32>;

/// Direction numbers of one dimension as binary fractions, by the recurrence of [Joe2008].
Directions directions(const Polynomial& polynomial) {
  Directions v{};
  const unsigned s = polynomial.degree;
  for (unsigned j = 0; j < v.size(); ++j) {
    if (j < s) {
      v[j] = polynomial.first[j] << (31 - j);
      continue;
    }
    v[j] = v[j - s] ^ v[j - s] >> s;
    for (unsigned k = 1; k < s; ++k) {
      if (polynomial.coefficients >> (s - 1 - k) & 1u) v[j] ^= v[j - k];
    }
  }
  return v;
}

std::array<Directions, 4> all_directions() {
  std::array<Directions, 4> result;
  for (unsigned j = 0; j < 32; ++j) result[0][j] = 1u << (31 - j);  // van der Corput
  result[1] = directions({1, 0, {1}});
  result[2] = directions({2, 1, {1, 3}});
  result[3] = directions({3, 1, {1, 3, 1}});
  return result;
}

}  // namespace

std::uint32_t sobol(std::uint32_t index, unsigned dimension) {
  static const std::array<Directions, 4> kDirections = all_directions();
  std::uint32_t fraction = 0;
  for (unsigned j = 0; index >> j != 0; ++j) {
    if (index >> j & 1u) fraction ^= kDirections[dimension][j];
    if (j == 31) break;
  }
  return fraction;
}

std::uint32_t owen_scramble(std::uint32_t fraction, std::uint32_t seed) {
  // Additions and multiplications carry upward only, so that in the mirror image a digit depends on those before it
  // [Burley2020]. Constants of [Vegdahl2021].
  std::uint32_t x = mirrored(fraction);
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= seed >> 16 | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return mirrored(x);
}

Words SampleRandom::block(std::uint32_t index) const {
  if (set_bits_ == 0) return pcg4d({pixel_, path_, index, seed_});
  const Words seeds = pcg4d({pixel_, path_ >> set_bits_, index, seed_});
  // The set's paths in an order of this block's own: the path's number within the set scrambled as a binary fraction,
  // read from its last digit and then from its first.
  const std::uint32_t unit = 32 - set_bits_;
  const std::uint32_t backward = mirrored(owen_scramble(mirrored(path_), seeds[0] ^ seeds[1]));
  const std::uint32_t shuffled = owen_scramble(backward << unit, seeds[2] ^ seeds[3]) >> unit;
  Words point;
  for (unsigned d = 0; d < 4; ++d) point[d] = owen_scramble(sobol(shuffled, d), seeds[d]);
  // The first two dimensions go to the numbers that make a point of the film, a point of a light, a direction.
  if (index == 0 || index >= kReserved) return point;
  if (index % 2 == 1) return {point[2], point[3], point[0], point[1]};
  return {point[2], point[0], point[1], point[3]};
}

}  // namespace etendue::reference
