#pragma once
/// Random numbers as a pure function of (seed, pixel, path, block); docs/conventions.md, "Random numbers" and "Sobol
/// sets".

#include <array>
#include <cstdint>

namespace etendue::reference {

using Words = std::array<std::uint32_t, 4>;

/// Four independent 32-bit words. Source: [Jarzynski2020], listing of pcg4d.
inline Words pcg4d(Words v) {
  const auto mix = [&v] {
    v[0] += v[1] * v[3];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    v[3] += v[1] * v[2];
  };
  for (std::uint32_t& word : v) word = word * 1664525u + 1013904223u;
  mix();
  for (std::uint32_t& word : v) word ^= word >> 16;
  mix();
  return v;
}

/// Float in [0,1) from the top 24 bits; never 1, exact in single and double precision.
inline double unit_float(std::uint32_t word) {
  return static_cast<double>(word >> 8) * 0x1p-24;
}

/// Component `dimension` (0 … 3) of point `index` of the Sobol sequence, as binary fraction.
std::uint32_t sobol(std::uint32_t index, unsigned dimension);
/// Owen scrambling of a binary fraction: every digit is flipped or not by a hash of the digits before it.
std::uint32_t owen_scramble(std::uint32_t fraction, std::uint32_t seed);

/// The random words of one path, block by block.
class SampleRandom {
 public:
  /// With `set_bits` > 0, paths come in Sobol sets of 2^set_bits.
  SampleRandom(std::uint32_t seed, std::uint32_t pixel, std::uint32_t path, std::uint32_t set_bits = 0)
      : seed_(seed), pixel_(pixel), path_(path), set_bits_(set_bits) {}

  struct Filter {
    double x, y;  ///< [0,1)
  };
  struct Lens {
    double blade, u, v;  ///< [0,1)
  };
  struct Light {
    std::uint32_t emitter, primitive;  ///< whole words, for integer thresholds
    double u, v;                       ///< [0,1)
  };
  struct Material {
    double lobe, u, v, roulette;  ///< [0,1)
  };

  struct Environment {
    std::uint32_t row, column;  ///< whole words, for integer thresholds
    double across, down;        ///< [0,1)
  };

  Filter filter() const {
    const auto words = block(0);
    return {unit_float(words[0]), unit_float(words[1])};
  }
  /// Numbers for a point of the aperture, or a direction of the meter's hemisphere.
  Lens lens() const {
    const auto words = block((1u << 31) + (1u << 24));
    return {unit_float(words[0]), unit_float(words[1]), unit_float(words[2])};
  }
  /// Numbers for next-event estimation at surface vertex `k` (0 is the first hit).
  Light light(std::uint32_t k) const {
    const auto words = block(1 + 2 * k);
    return {words[0], words[1], unit_float(words[2]), unit_float(words[3])};
  }
  /// Numbers for sampling the material and for roulette at surface vertex `k`.
  Material material(std::uint32_t k) const {
    const auto words = block(2 + 2 * k);
    return {unit_float(words[0]), unit_float(words[1]), unit_float(words[2]), unit_float(words[3])};
  }

  /// Numbers for a direction of the environment at surface vertex `k`.
  Environment environment(std::uint32_t k) const {
    const auto words = block(kReserved + (3u << 24) + k % (1u << 24));
    return {words[0], words[1], unit_float(words[2]), unit_float(words[3])};
  }

  /// What an adapter decides about a surface at vertex `k`, or about one met by a shadow ray from there.
  struct Decision {
    std::uint32_t vertex;
    std::uint32_t instance, primitive;
    bool behind;  ///< the surface is met on the side behind its geometric normal
    bool shadow_ray;
  };
  /// A number in [0,1) for the adapter in row `material` of the table; docs/conventions.md, "Adapters".
  double choice(const Decision& d, std::uint32_t material) const {
    Words words = pcg4d({pixel_, path_, kReserved + (2u << 24) + d.vertex % (1u << 24), seed_});
    words[0] += d.instance;
    words[1] += d.primitive;
    words[2] += (d.behind ? 1u : 0u) + (d.shadow_ray ? 2u : 0u);
    words[3] += material;
    return unit_float(pcg4d(words)[0]);
  }

  Words block(std::uint32_t index) const;

 private:
  static constexpr std::uint32_t kReserved = 1u << 31;  ///< the first of the blocks for later kinds of numbers
  std::uint32_t seed_, pixel_, path_, set_bits_;
};

}  // namespace etendue::reference
