#include "compile/twins.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>

#include "core/parallel.h"

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
std::uint32_t hash_of(const gpu::Primitive& p) {
  std::uint64_t hash = kind_of(p);
  for (const glm::vec3& v : {glm::vec3(p.p0), glm::vec3(p.p1), glm::vec3(p.p2)}) {
    for (int axis = 0; axis < 3; ++axis) hash = mix(hash * 3 + std::bit_cast<std::uint32_t>(v[axis] + 0.0f));
  }
  return static_cast<std::uint32_t>(hash);
}

constexpr std::size_t kMostShards = 256;
constexpr std::size_t kFewPrimitives = 1u << 14;  // one shard, one thread

/// The numbers of the primitives, ascending in each shard; primitives of equal geometry are in the same one. Threads
/// search shards side by side, and the table of one stays in a cache.
struct Shards {
  std::vector<std::uint32_t> hashes;   // of the primitives
  std::vector<std::uint32_t> members;  // shard by shard
  std::vector<std::size_t> first;      // of each shard, into members, and the end

  explicit Shards(const std::vector<gpu::Primitive>& primitives)
      : hashes(primitives.size()),
        members(primitives.size()),
        first((primitives.size() > kFewPrimitives ? kMostShards : 1) + 1, 0) {
    parallel_for(primitives.size(), kFewPrimitives, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) hashes[i] = hash_of(primitives[i]);
    });
    for (const std::uint32_t hash : hashes) ++first[shard_of(hash) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::size_t> next = first;
    for (std::uint32_t i = 0; i < primitives.size(); ++i) members[next[shard_of(hashes[i])]++] = i;
  }
  std::size_t count() const { return first.size() - 1; }
  std::size_t shard_of(std::uint32_t hash) const { return (hash >> 24) % count(); }
  std::span<const std::uint32_t> operator[](std::size_t shard) const {
    return std::span(members).subspan(first[shard], first[shard + 1] - first[shard]);
  }
};

}  // namespace

std::vector<Twin> find_twins(const std::vector<gpu::Primitive>& primitives,
                             const std::vector<bool>& passing_instances) {
  const Shards shards(primitives);
  std::vector<std::vector<Twin>> found(shards.count());
  const auto search = [&](std::span<const std::uint32_t> members, std::vector<Twin>& twins) {
    // Open addressing over bare numbers.
    std::vector<std::uint32_t> table(std::bit_ceil(2 * members.size() + 1), kNone);
    for (const std::uint32_t i : members) {
      if (never_hit(primitives[i])) {
        twins.push_back({i, i});
        continue;
      }
      const std::uint32_t hash = shards.hashes[i];
      std::size_t at = hash & (table.size() - 1);
      while (table[at] != kNone &&
             (shards.hashes[table[at]] != hash || !same_geometry(primitives[table[at]], primitives[i])))
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
  };
  parallel_for(found.size(), 1, [&](std::uint64_t shard, std::uint64_t) { search(shards[shard], found[shard]); });
  std::vector<Twin> twins;
  for (const std::vector<Twin>& part : found) twins.insert(twins.end(), part.begin(), part.end());
  std::ranges::sort(twins, {}, &Twin::primitive);
  return twins;
}

}  // namespace etendue
