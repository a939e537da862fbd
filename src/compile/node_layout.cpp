#include "compile/node_layout.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/core.h>

#include "core/errors.h"

namespace etendue {
namespace {

constexpr float kGridMax = 255.0f;

// Smallest exponent with 255 · 2^e >= extent, biased by 127 and kept in the range of normal floats.
std::uint32_t biased_exponent(float extent) {
  int e = 0;
  std::frexp(extent / kGridMax, &e);
  if (extent == 0.0f) e = -126;
  return static_cast<std::uint32_t>(std::max(e, -126) + 127);
}

float exponent_scale(std::uint32_t biased) {
  return std::bit_cast<float>(biased << 23);
}
std::uint32_t scale_exponent(float scale) {
  return std::bit_cast<std::uint32_t>(scale) >> 23;
}

// The scale of a grid from `origin` to `upper`, with an exponent of at least `least`.
float fit_scale(float origin, float upper, std::uint32_t least) {
  std::uint32_t e = std::max(biased_exponent(upper - origin), least);
  // The far plane must be within reach after rounding, too.
  while (origin + kGridMax * exponent_scale(e) < upper) ++e;
  return exponent_scale(e);
}

// Grid coordinates whose decoded planes enclose [lower, upper].
void quantize_axis(float lower, float upper, float origin, float scale, std::uint32_t& q_lower,
                   std::uint32_t& q_upper) {
  q_lower = static_cast<std::uint32_t>(std::clamp(std::floor((lower - origin) / scale), 0.0f, kGridMax));
  q_upper = static_cast<std::uint32_t>(std::clamp(std::ceil((upper - origin) / scale), 0.0f, kGridMax));
  while (q_lower > 0 && origin + static_cast<float>(q_lower) * scale > lower) --q_lower;
  while (q_upper < 255 && origin + static_cast<float>(q_upper) * scale < upper) ++q_upper;
}

}  // namespace

GridBox quantize(const NodeGrid& grid, const Box& box) {
  GridBox q;
  for (int a = 0; a < 3; ++a) {
    quantize_axis(box.lower[a], box.upper[a], grid.origin[a], grid.scale[a], q.lower[a], q.upper[a]);
  }
  return q;
}

NodeGrid NodeLayout<4>::fit_grid(const Box& box) {
  NodeGrid grid{box.lower, {}};
  for (int a = 0; a < 3; ++a) grid.scale[a] = fit_scale(box.lower[a], box.upper[a], 0);
  return grid;
}

void NodeLayout<4>::encode(const NodeGrid& grid, std::span<const GridBox, 4> boxes, const ChildGroup& group,
                           Texel* node) {
  Texel a(0u), b(0u), c(0u);
  for (int k = 0; k < 3; ++k) {
    a[k] = std::bit_cast<std::uint32_t>(grid.origin[k]);
    a.w |= scale_exponent(grid.scale[k]) << (8 * k);
    for (std::uint32_t i = 0; i < 4; ++i) {
      b[k] |= boxes[i].lower[k] << (8 * i);
      c[k] |= boxes[i].upper[k] << (8 * i);
    }
  }
  a.w |= gpu::kRecordNode | group.count << gpu::kNode4CountShift;
  b.w = group.first_texel / kSlotTexels;
  node[0] = a, node[1] = b, node[2] = c;
}

NodeGrid NodeLayout<4>::grid(const Texel* node) {
  NodeGrid grid;
  for (int k = 0; k < 3; ++k) {
    grid.origin[k] = std::bit_cast<float>(node[0][k]);
    grid.scale[k] = exponent_scale(node[0].w >> (8 * k) & 0xffu);
  }
  return grid;
}

GridBox NodeLayout<4>::box(const Texel* node, std::uint32_t child) {
  return {glm::uvec3(node[1]) >> (8 * child) & 0xffu, glm::uvec3(node[2]) >> (8 * child) & 0xffu};
}

ChildGroup NodeLayout<4>::group(const Texel* node) {
  return {node[1].w * kSlotTexels, node[0].w >> gpu::kNode4CountShift & 7u, 0};
}

NodeGrid NodeLayout<8>::fit_grid(const Box& box) {
  NodeGrid grid;
  for (int a = 0; a < 3; ++a) {
    const float steps = std::floor(box.lower[a] / gpu::kNode8OriginStep);
    if (!(box.lower[a] >= -2.0f) || !(box.upper[a] < 2.0f)) {
      throw Error(ErrorKind::bug,
                  fmt::format("A node of the tree spans [{}, {}] along axis {}, which is outside [-2, 2).",
                              box.lower[a], box.upper[a], a));
    }
    // 27 bits: below 1/2 in magnitude the product is a small integer, above it floats are multiples of the step.
    grid.origin[a] = steps * gpu::kNode8OriginStep;
    grid.scale[a] = fit_scale(grid.origin[a], box.upper[a], gpu::kNode8ExponentBias);
  }
  return grid;
}

void NodeLayout<8>::encode(const NodeGrid& grid, std::span<const GridBox, 8> boxes, const ChildGroup& group,
                           Texel* node) {
  node[0] = Texel(0u);
  for (int k = 0; k < 3; ++k) {
    const auto steps = static_cast<std::int32_t>(grid.origin[k] / gpu::kNode8OriginStep);
    node[0][k] = static_cast<std::uint32_t>(steps) << gpu::kNode8ExponentBits |
                 (scale_exponent(grid.scale[k]) - gpu::kNode8ExponentBias);
    Texel& planes = node[1 + k];
    planes = Texel(0u);
    for (std::uint32_t i = 0; i < 8; ++i) {
      planes[static_cast<int>(i / 4)] |= boxes[i].lower[k] << (8 * (i % 4));
      planes[static_cast<int>(2 + i / 4)] |= boxes[i].upper[k] << (8 * (i % 4));
    }
  }
  node[0].w = gpu::kRecordNode | (group.count - 1) << gpu::kNode8CountShift |
              std::min(group.inner, 7u) << gpu::kNode8InnerShift | group.first_texel / kGroupTexels;
}

NodeGrid NodeLayout<8>::grid(const Texel* node) {
  NodeGrid grid;
  for (int k = 0; k < 3; ++k) {
    const auto steps = static_cast<std::int32_t>(node[0][k]) >> gpu::kNode8ExponentBits;
    grid.origin[k] = static_cast<float>(steps) * gpu::kNode8OriginStep;
    grid.scale[k] = exponent_scale((node[0][k] & ((1u << gpu::kNode8ExponentBits) - 1)) + gpu::kNode8ExponentBias);
  }
  return grid;
}

GridBox NodeLayout<8>::box(const Texel* node, std::uint32_t child) {
  GridBox q;
  for (int k = 0; k < 3; ++k) {
    q.lower[k] = node[1 + k][static_cast<int>(child / 4)] >> (8 * (child % 4)) & 0xffu;
    q.upper[k] = node[1 + k][static_cast<int>(2 + child / 4)] >> (8 * (child % 4)) & 0xffu;
  }
  return q;
}

ChildGroup NodeLayout<8>::group(const Texel* node) {
  const std::uint32_t w = node[0].w;
  return {(w & gpu::kNode8BaseMask) * kGroupTexels, (w >> gpu::kNode8CountShift & 7u) + 1,
          w >> gpu::kNode8InnerShift & 7u};
}

}  // namespace etendue
