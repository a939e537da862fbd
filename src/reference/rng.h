#pragma once
/// Random numbers as a pure function of (seed, pixel, sample, block); docs/conventions.md, "Random numbers".

#include <array>
#include <cstdint>

namespace etendue::reference {

/// Four independent 32-bit words. Source: [Jarzynski2020], listing of pcg4d.
inline std::array<std::uint32_t, 4> pcg4d(std::array<std::uint32_t, 4> v) {
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

/// The random words of one sample, block by block.
class SampleRandom {
 public:
  SampleRandom(std::uint32_t seed, std::uint32_t pixel, std::uint32_t sample)
      : seed_(seed), pixel_(pixel), sample_(sample) {}

  struct Filter {
    double x, y;  ///< [0,1)
  };
  struct Light {
    std::uint32_t emitter, primitive;  ///< whole words, for integer thresholds
    double u, v;                       ///< [0,1)
  };
  struct Material {
    double lobe, u, v, roulette;  ///< [0,1)
  };

  Filter filter() const {
    const auto words = block(0);
    return {unit_float(words[0]), unit_float(words[1])};
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

 private:
  std::array<std::uint32_t, 4> block(std::uint32_t index) const { return pcg4d({pixel_, sample_, index, seed_}); }

  std::uint32_t seed_, pixel_, sample_;
};

}  // namespace etendue::reference
