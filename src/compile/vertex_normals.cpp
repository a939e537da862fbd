#include "compile/vertex_normals.h"

#include <cmath>
#include <cstdint>

namespace etendue {
namespace {

constexpr std::uint32_t kMask = (1u << gpu::kOctahedronBits) - 1;
constexpr std::uint32_t kLowMask = (1u << gpu::kOctahedronLowBits) - 1;

struct Folded {
  std::uint32_t x, y;  // kOctahedronBits each, two's complement
};

std::uint32_t whole(double v) {
  return static_cast<std::uint32_t>(std::lround(v * gpu::kOctahedron)) & kMask;
}

Folded fold(const glm::dvec3& n) {
  const glm::dvec3 p = n / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  if (p.z >= 0.0) return {whole(p.x), whole(p.y)};
  return {whole(std::copysign(1.0 - std::abs(p.y), p.x)), whole(std::copysign(1.0 - std::abs(p.x), p.y))};
}

std::uint32_t low_word(Folded f) {
  return f.x | (f.y & kLowMask) << gpu::kOctahedronBits;
}

}  // namespace

gpu::uvec4 pack_normals(const glm::dvec3& n0, const glm::dvec3& n1, const glm::dvec3& n2) {
  const Folded a = fold(n0), b = fold(n1), c = fold(n2);
  const auto high = [](Folded f, std::uint32_t place) {
    return f.y >> gpu::kOctahedronLowBits << place * gpu::kOctahedronHighBits;
  };
  return {low_word(a), low_word(b), low_word(c), high(a, 0) | high(b, 1) | high(c, 2)};
}

}  // namespace etendue
