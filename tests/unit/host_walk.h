#pragma once
/// The walk of shaders/trace.glsl on the host, for tests and measurements: the same order of visits, the same
/// single-precision arithmetic.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

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
  std::uint32_t slot = gpu::kNone;
};
/// Nodes and primitives visited.
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
  bool intersect(const gpu::Primitive& p, std::uint32_t slot, HostHit& hit) const {
    const glm::vec3 a = p.p0 - ray_.o, b = p.p1 - ray_.o, c = p.p2 - ray_.o;
    const glm::vec2 pa = project(a), pb = project(b), pc = project(c);
    const float u = pb.x * pc.y - pc.x * pb.y, v = pc.x * pa.y - pa.x * pc.y, w = pa.x * pb.y - pb.x * pa.y;
    const float det = u + v + w;
    const float t = (u * dot(ray_.d, a) + v * dot(ray_.d, b) + w * dot(ray_.d, c)) * (1.0f / det);
    const bool inside = std::min(u, std::min(v, w)) >= 0.0f || std::max(u, std::max(v, w)) <= 0.0f;
    if (!inside || det == 0.0f || !(t > ray_.t_min) || !(t < hit.t)) return false;
    hit = {t, slot};
    return true;
  }

 private:
  static float dot(const glm::vec3& a, const glm::vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
  glm::vec2 project(const glm::vec3& p) const { return {dot(s_, p), dot(t_, p)}; }
  HostRay ray_;
  glm::vec3 s_, t_;
};

/// Nearest hit in the tree, or any when `any_hit`. The primitives before the root are not looked at.
template <std::uint32_t width>
HostHit host_walk(const WideBvh& bvh, const HostRay& ray, bool any_hit, Visits& visits) {
  const TreeReader<width> tree(bvh.texels);
  const HostFrame frame(ray);
  glm::vec3 inv;
  for (int a = 0; a < 3; ++a) {
    const float d = std::abs(ray.d[a]) < 1e-20f ? (ray.d[a] >= 0.0f ? 1e-20f : -1e-20f) : ray.d[a];
    inv[a] = 1.0f / d;
  }
  HostHit hit{ray.t_max};
  std::vector<std::uint32_t> stack{bvh.root};
  while (!stack.empty()) {
    const std::uint32_t slot = stack.back();
    stack.pop_back();
    if (!tree.is_node(slot)) {
      ++visits.primitives;
      if (frame.intersect(tree.primitive(slot), slot, hit) && any_hit) return hit;
      continue;
    }
    ++visits.nodes;
    const NodeGrid grid = tree.grid(slot);
    std::array<std::uint32_t, width> keys;
    std::size_t found = 0;
    for (std::uint32_t i = 0; i < tree.child_count(slot); ++i) {
      const GridBox box = tree.grid_box(slot, i);
      float near = 0.0f, far = hit.t;
      for (int a = 0; a < 3; ++a) {
        const float scale = grid.scale[a] * inv[a];
        const float b = (grid.origin[a] - ray.o[a]) * inv[a], margin = std::abs(b) * 3e-7f;
        const auto lower = static_cast<float>(box.lower[a]), upper = static_cast<float>(box.upper[a]);
        near = std::max(near, (inv[a] >= 0.0f ? lower : upper) * scale + (b - margin));
        far = std::min(far, (inv[a] >= 0.0f ? upper : lower) * scale + (b + margin));
      }
      if (near > far * (1.0f + 1e-6f)) continue;
      // Farthest first, so that the nearest is on top of the stack.
      const std::uint32_t key = (std::bit_cast<std::uint32_t>(near) & ~(width - 1)) | i;
      std::size_t at = found++;
      for (; at > 0 && keys[at - 1] < key; --at) keys[at] = keys[at - 1];
      keys[at] = key;
    }
    for (std::size_t i = 0; i < found; ++i) stack.push_back(tree.child_slot(slot, keys[i] & (width - 1)));
  }
  return hit;
}

/// Nearest hit over all primitives of the tree.
inline HostHit host_brute_force(const WideBvh& bvh, const std::vector<gpu::Primitive>& primitives, const HostRay& ray) {
  const HostFrame frame(ray);
  HostHit hit{ray.t_max};
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    if (bvh.slot_of[i] >= bvh.root) frame.intersect(primitives[i], bvh.slot_of[i], hit);
  }
  return hit;
}

}  // namespace etendue::test
