#pragma once
/// The walk of shaders/trace.glsl on the host, for tests and measurements: the same order of visits, the same
/// single-precision arithmetic.

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "compile/wide_bvh.h"

namespace etendue::test {

struct HostRay {
  glm::vec3 o;
  float t_min;
  glm::vec3 d;
  float t_max;
};
struct HostHit {
  float t;
  std::uint32_t record = gpu::kNone;
};
/// Records visited.
struct Visits {
  std::uint64_t nodes = 0, primitives = 0;
};

// A triangle projected along the ray; see intersect.glsl.
class HostFrame {
 public:
  explicit HostFrame(const HostRay& ray) : ray_(ray) {
    const glm::vec3& n = ray.d;
    const float sign = n.z >= 0.0f ? 1.0f : -1.0f, a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    s_ = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    t_ = {b, sign + n.y * n.y * a, -n.y};
  }
  bool intersect(const gpu::Record& record, std::uint32_t index, HostHit& hit) const {
    gpu::Primitive p;
    std::memcpy(static_cast<void*>(&p), &record, sizeof p);
    const glm::vec3 a = p.p0 - ray_.o, b = p.p1 - ray_.o, c = p.p2 - ray_.o;
    const glm::vec2 pa = project(a), pb = project(b), pc = project(c);
    const float u = pb.x * pc.y - pc.x * pb.y, v = pc.x * pa.y - pa.x * pc.y, w = pa.x * pb.y - pb.x * pa.y;
    const float det = u + v + w;
    const float t = (u * dot(ray_.d, a) + v * dot(ray_.d, b) + w * dot(ray_.d, c)) * (1.0f / det);
    const bool inside = std::min(u, std::min(v, w)) >= 0.0f || std::max(u, std::max(v, w)) <= 0.0f;
    if (!inside || det == 0.0f || !(t > ray_.t_min) || !(t < hit.t)) return false;
    hit = {t, index};
    return true;
  }

 private:
  static float dot(const glm::vec3& a, const glm::vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  glm::vec2 project(const glm::vec3& p) const { return {dot(s_, p), dot(t_, p)}; }
  HostRay ray_;
  glm::vec3 s_, t_;
};

/// Nearest hit in the tree, or any when `any_hit`. The records before the root are not looked at.
inline HostHit host_walk(const WideBvh& tree, const HostRay& ray, bool any_hit, Visits& visits) {
  const HostFrame frame(ray);
  glm::vec3 inv;
  for (int a = 0; a < 3; ++a) {
    const float d = std::abs(ray.d[a]) < 1e-20f ? (ray.d[a] >= 0.0f ? 1e-20f : -1e-20f) : ray.d[a];
    inv[a] = 1.0f / d;
  }
  HostHit hit{ray.t_max};
  std::vector<std::uint32_t> stack{tree.root};
  while (!stack.empty()) {
    const std::uint32_t index = stack.back();
    const gpu::Record& r = tree.records[index];
    stack.pop_back();
    if (!is_node(r)) {
      ++visits.primitives;
      if (frame.intersect(r, index, hit) && any_hit) return hit;
      continue;
    }
    ++visits.nodes;
    std::array<std::uint32_t, 4> keys;
    std::size_t found = 0;
    for (std::uint32_t i = 0; i < child_count(r); ++i) {
      float near = 0.0f, far = hit.t;
      for (int a = 0; a < 3; ++a) {
        const float scale = std::bit_cast<float>((r.a.w >> (8 * a) & 0xffu) << 23) * inv[a];
        const float b = (std::bit_cast<float>(r.a[a]) - ray.o[a]) * inv[a], margin = std::abs(b) * 3e-7f;
        const auto lower = static_cast<float>(r.b[a] >> (8 * i) & 0xffu),
                   upper = static_cast<float>(r.c[a] >> (8 * i) & 0xffu);
        near = std::max(near, (inv[a] >= 0.0f ? lower : upper) * scale + (b - margin));
        far = std::min(far, (inv[a] >= 0.0f ? upper : lower) * scale + (b + margin));
      }
      if (near > far * (1.0f + 1e-6f)) continue;
      // Farthest first, so that the nearest is on top of the stack.
      const std::uint32_t key = (std::bit_cast<std::uint32_t>(near) & 0xfffffffcu) | i;
      std::size_t at = found++;
      for (; at > 0 && keys[at - 1] < key; --at) keys[at] = keys[at - 1];
      keys[at] = key;
    }
    for (std::size_t i = 0; i < found; ++i) stack.push_back(child_base(r) + (keys[i] & 3u));
  }
  return hit;
}

/// Nearest hit over all primitive records from the root on.
inline HostHit host_brute_force(const WideBvh& tree, const HostRay& ray) {
  const HostFrame frame(ray);
  HostHit hit{ray.t_max};
  for (std::uint32_t i = tree.root; i < tree.records.size(); ++i) {
    if (!is_node(tree.records[i])) frame.intersect(tree.records[i], i, hit);
  }
  return hit;
}

}  // namespace etendue::test
