#include "compile/twins.h"

#include <bit>

namespace etendue {
namespace {

constexpr std::uint32_t kNone = ~0u;

gpu::uint kind_of(const gpu::Primitive& p) {
  return p.kind & gpu::kPrimitiveKindMask;
}

bool same_geometry(const gpu::Primitive& a, const gpu::Primitive& b) {
  return a.p0 == b.p0 && a.p1 == b.p1 && a.p2 == b.p2 && kind_of(a) == kind_of(b);
}

bool never_hit(const gpu::Primitive& p) {
  return kind_of(p) == gpu::kPrimitiveTriangle && (p.p0 == p.p1 || p.p1 == p.p2 || p.p2 == p.p0);
}

std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// Equal for equal geometry: −0 is hashed as 0.
std::uint64_t hash_of(const gpu::Primitive& p) {
  std::uint64_t hash = kind_of(p);
  for (const glm::vec3& v : {glm::vec3(p.p0), glm::vec3(p.p1), glm::vec3(p.p2)}) {
    for (int axis = 0; axis < 3; ++axis) hash = mix(hash * 3 + std::bit_cast<std::uint32_t>(v[axis] + 0.0f));
  }
  return hash;
}

}  // namespace

std::vector<Twin> find_twins(const std::vector<gpu::Primitive>& primitives,
                             const std::vector<bool>& passing_instances) {
  std::vector<Twin> twins;
  // Open addressing over bare numbers.
  std::vector<std::uint32_t> table(std::bit_ceil(2 * primitives.size() + 1), kNone);
  for (std::uint32_t i = 0; i < primitives.size(); ++i) {
    if (never_hit(primitives[i])) {
      twins.push_back({i, i});
      continue;
    }
    std::size_t at = hash_of(primitives[i]) & (table.size() - 1);
    while (table[at] != kNone && !same_geometry(primitives[table[at]], primitives[i]))
      at = (at + 1) & (table.size() - 1);
    // A primitive that rays may pass can only stand for copies within its own instance.
    const bool passed = table[at] != kNone && !passing_instances.empty() &&
                        primitives[table[at]].instance != primitives[i].instance &&
                        passing_instances[primitives[table[at]].instance];
    if (table[at] == kNone || passed) {
      table[at] = i;
    } else {
      twins.push_back({i, table[at]});
    }
  }
  return twins;
}

}  // namespace etendue
