#include "compile/wide_bvh.h"

#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/core.h>

#include "core/errors.h"

namespace etendue {
namespace {

constexpr std::uint32_t kWidth = 4;
constexpr std::uint64_t kMaxRecords = std::uint64_t{1} << 25;

struct Children {
  std::uint32_t node[kWidth];  // of the binary tree
  std::uint32_t count = 0;
};

// Opens the child with the largest surface until the node is full or only leaves are left: the collapse that keeps the
// expected number of visits low [Wald2008].
Children collect_children(const Bvh& bvh, std::uint32_t node) {
  Children children;
  const std::uint32_t first = bvh.nodes[node].first;
  children.node[children.count++] = first;
  children.node[children.count++] = first + 1;
  while (children.count < kWidth) {
    std::uint32_t best = kWidth;
    float best_area = -1.0f;
    for (std::uint32_t i = 0; i < children.count; ++i) {
      const BvhBuildNode& n = bvh.nodes[children.node[i]];
      if (n.count == 0 && n.box.half_area() > best_area) {
        best_area = n.box.half_area();
        best = i;
      }
    }
    if (best == kWidth) break;
    const std::uint32_t opened = bvh.nodes[children.node[best]].first;
    children.node[best] = opened;
    children.node[children.count++] = opened + 1;
  }
  return children;
}

// Smallest exponent with 255 · 2^e >= extent, biased by 127 and kept in the range of normal floats.
std::uint32_t biased_exponent(float extent) {
  int e = 0;
  std::frexp(extent / 255.0f, &e);
  if (extent == 0.0f) e = -126;
  return static_cast<std::uint32_t>(std::max(e, -126) + 127);
}

float exponent_scale(std::uint32_t biased) {
  return std::bit_cast<float>(biased << 23);
}

// Grid coordinates whose decoded planes enclose [lower, upper].
void quantize(float lower, float upper, float origin, float scale, std::uint32_t& q_lower, std::uint32_t& q_upper) {
  q_lower = static_cast<std::uint32_t>(std::clamp(std::floor((lower - origin) / scale), 0.0f, 255.0f));
  q_upper = static_cast<std::uint32_t>(std::clamp(std::ceil((upper - origin) / scale), 0.0f, 255.0f));
  while (q_lower > 0 && origin + static_cast<float>(q_lower) * scale > lower) --q_lower;
  while (q_upper < 255 && origin + static_cast<float>(q_upper) * scale < upper) ++q_upper;
}

gpu::Record encode_node(const Bvh& bvh, const Box& box, const Children& children, std::uint32_t base) {
  gpu::Record r{};
  std::uint32_t exponents = 0;
  for (int a = 0; a < 3; ++a) {
    std::uint32_t e = biased_exponent(box.upper[a] - box.lower[a]);
    // The far plane must be reachable after rounding too.
    while (box.lower[a] + 255.0f * exponent_scale(e) < box.upper[a]) ++e;
    exponents |= e << (8 * a);
    r.a[a] = std::bit_cast<std::uint32_t>(box.lower[a]);
    for (std::uint32_t i = 0; i < kWidth; ++i) {
      std::uint32_t lo = 255, hi = 0;  // an empty box: never hit
      if (i < children.count) {
        const Box& child = bvh.nodes[children.node[i]].box;
        quantize(child.lower[a], child.upper[a], box.lower[a], exponent_scale(e), lo, hi);
      }
      r.b[a] |= lo << (8 * i);
      r.c[a] |= hi << (8 * i);
    }
  }
  r.a.w = exponents | gpu::kRecordNode | (children.count << gpu::kRecordChildCountShift);
  r.b.w = base;
  return r;
}

}  // namespace

gpu::Record to_record(const gpu::Primitive& p) {
  gpu::Record r;
  static_assert(sizeof r == sizeof p);
  std::memcpy(&r, &p, sizeof r);
  return r;
}

WideBvh make_wide_bvh(const Bvh& bvh, const std::vector<gpu::Primitive>& primitives) {
  struct Task {
    std::uint32_t node, record, depth;
  };
  WideBvh wide;
  wide.slot_of.resize(primitives.size());
  wide.records.resize(1);
  std::vector<Task> pending{{0, 0, 1}};
  while (!pending.empty()) {
    const Task task = pending.back();
    pending.pop_back();
    const BvhBuildNode& node = bvh.nodes[task.node];
    if (node.count > 0) {
      const std::uint32_t primitive = bvh.order[node.first];
      wide.slot_of[primitive] = task.record;
      wide.records[task.record] = to_record(primitives[primitive]);
      continue;
    }
    wide.depth = std::max(wide.depth, task.depth);
    const Children children = collect_children(bvh, task.node);
    const std::size_t base = (wide.records.size() + 1) / 2 * 2;
    if (base + kWidth > kMaxRecords) {
      throw Error(ExitCode::scene_error, fmt::format("The scene has {} primitives; their tree needs more than the {} "
                                                     "records that can be addressed. Use coarser meshes.",
                                                     primitives.size(), kMaxRecords));
    }
    wide.records.resize(base + children.count);
    wide.records[task.record] = encode_node(bvh, node.box, children, static_cast<std::uint32_t>(base));
    for (std::uint32_t i = children.count; i-- > 0;) {
      pending.push_back({children.node[i], static_cast<std::uint32_t>(base + i), task.depth + 1});
    }
  }
  return wide;
}

bool is_node(const gpu::Record& record) {
  return (record.a.w & gpu::kRecordNode) != 0;
}
std::uint32_t child_count(const gpu::Record& node) {
  return node.a.w >> gpu::kRecordChildCountShift & 7u;
}
std::uint32_t child_base(const gpu::Record& node) {
  return node.b.w;
}

Box decode_child_box(const gpu::Record& node, std::uint32_t child) {
  Box box;
  for (int a = 0; a < 3; ++a) {
    const auto origin = std::bit_cast<float>(node.a[a]);
    const float scale = exponent_scale(node.a.w >> (8 * a) & 0xffu);
    box.lower[a] = origin + static_cast<float>(node.b[a] >> (8 * child) & 0xffu) * scale;
    box.upper[a] = origin + static_cast<float>(node.c[a] >> (8 * child) & 0xffu) * scale;
  }
  return box;
}

}  // namespace etendue
