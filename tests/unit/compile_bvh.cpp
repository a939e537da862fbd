/// The tree builder and the collapse to wide quantised nodes.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>

#include <gtest/gtest.h>

#include "compile/bvh.h"
#include "compile/compiled_scene.h"
#include "compile/few_primitives.h"
#include "compile/reinsertion.h"
#include "compile/wide_bvh.h"
#include "core/errors.h"
#include "core/parallel.h"
#include "tree_widths.h"

namespace etendue {
namespace {

Box box_of(const gpu::Primitive& p) {
  Box box;
  box.extend(p.p0);
  box.extend(p.p1);
  box.extend(p.p2);
  return box;
}
std::vector<Box> boxes_of(const std::vector<gpu::Primitive>& primitives) {
  std::vector<Box> boxes;
  boxes.reserve(primitives.size());
  for (const gpu::Primitive& p : primitives) boxes.push_back(box_of(p));
  return boxes;
}

// Named soups that are hard on builders.
struct Soup {
  const char* name;
  std::vector<gpu::Primitive> primitives;
};
std::vector<Soup> soups() {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  const auto point = [&] {
    const float x = u(random), y = u(random);
    return glm::vec3(x, y, u(random));
  };
  std::vector<Soup> out;
  const auto add = [&](const char* name, std::uint32_t count, auto vertices) {
    out.push_back({name, {}});
    for (std::uint32_t i = 0; i < count; ++i) {
      gpu::Primitive p{};
      vertices(i, p);
      p.primitive = i;
      out.back().primitives.push_back(p);
    }
  };
  const auto small = [&](std::uint32_t, gpu::Primitive& p) {
    p.p0 = point();
    p.p1 = p.p0 + 0.05f * point();
    p.p2 = p.p0 + 0.05f * point();
  };
  for (const std::uint32_t count : {1u, 2u, 3u, 4u, 5u, 6u, 17u, 3000u}) add("random", count, small);
  add("large enough for several threads", 70000, small);
  add("all at one point", 777,
      [](std::uint32_t, gpu::Primitive& p) { p.p0 = p.p1 = p.p2 = glm::vec3(0.3f, -0.2f, 0.1f); });
  add("one triangle many times", 500, [](std::uint32_t, gpu::Primitive& p) {
    p.p0 = {0, 0, 0}, p.p1 = {1, 0, 0}, p.p2 = {0, 1, 0};
  });
  add("flat", 900, [&](std::uint32_t, gpu::Primitive& p) {
    p.p0 = point(), p.p1 = point(), p.p2 = point();
    p.p0.y = p.p1.y = p.p2.y = 0.25f;
  });
  add("sizes over 40 octaves", 1000, [&](std::uint32_t i, gpu::Primitive& p) {
    const float size = std::exp2(-static_cast<float>(i % 40));
    p.p0 = size * point(), p.p1 = size * point(), p.p2 = size * point();
  });
  add("geometric row", 300, [](std::uint32_t i, gpu::Primitive& p) {
    const float x = std::exp2(-0.4f * static_cast<float>(i));  // every split by position cuts off a single one
    p.p0 = {x, 0, 0}, p.p1 = {1.1f * x, 0, 0}, p.p2 = {x, 0.1f * x, 0};
  });
  add("denormal extents", 100, [&](std::uint32_t, gpu::Primitive& p) {
    p.p0 = 1e-39f * point(), p.p1 = 1e-39f * point(), p.p2 = 1e-39f * point();
  });
  return out;
}

bool contains(const Box& outer, const Box& inner) {
  return glm::all(glm::lessThanEqual(outer.lower, inner.lower)) &&
         glm::all(glm::greaterThanEqual(outer.upper, inner.upper));
}

// Walks the tree: boxes contain their children, every primitive is one leaf; returns the number of inner levels.
std::uint32_t check_binary(const Bvh& bvh, const std::vector<Box>& boxes) {
  std::vector<int> seen(boxes.size(), 0);
  std::uint32_t depth = 0, visited = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pending{{0, 0}};
  while (!pending.empty()) {
    const auto [index, level] = pending.back();
    pending.pop_back();
    const BvhNode& node = bvh.nodes.at(index);
    ++visited;
    depth = std::max(depth, level);
    if (node.leaf != 0) {
      ++seen.at(node.first);
      EXPECT_TRUE(contains(node.box, boxes[node.first]));
      continue;
    }
    EXPECT_EQ(bvh_sibling(node.first), node.first + 1);
    EXPECT_EQ(bvh_sibling(node.first + 1), node.first);
    for (const std::uint32_t child : {node.first, node.first + 1}) {
      EXPECT_TRUE(contains(node.box, bvh.nodes.at(child).box)) << index;
      pending.push_back({child, level + 1});
    }
  }
  EXPECT_EQ(visited, bvh.nodes.size()) << "nodes nobody points to";
  EXPECT_TRUE(std::ranges::all_of(seen, [](int n) { return n == 1; })) << "a primitive is missing or doubled";
  return depth;
}

TEST(CompileBvh, EveryPrimitiveIsOneLeafAndInAllBoxesAbove) {
  for (const Soup& soup : soups()) {
    SCOPED_TRACE(soup.name + std::string(", ") + std::to_string(soup.primitives.size()));
    const auto boxes = boxes_of(soup.primitives);
    const BvhConfig config;
    const Bvh bvh = build_bvh(boxes, {}, config);
    // Below median_depth every level halves what is left.
    EXPECT_LE(check_binary(bvh, boxes), config.median_depth + 32);
  }
}

// Areas of all inner boxes: what reinsertion lowers.
double inner_area(const Bvh& bvh) {
  double sum = 0.0;
  for (const BvhNode& node : bvh.nodes) sum += node.leaf != 0 ? 0.0 : double{node.box.half_area()};
  return sum;
}

TEST(CompileBvh, ReinsertionKeepsTheTreeWholeAndNeverRaisesItsCost) {
  for (const Soup& soup : soups()) {
    SCOPED_TRACE(soup.name + std::string(", ") + std::to_string(soup.primitives.size()));
    const auto boxes = boxes_of(soup.primitives);
    Bvh bvh = build_bvh(boxes);
    const double before = inner_area(bvh);
    reinsert_subtrees(bvh, {.max_depth = 80});
    EXPECT_LE(check_binary(bvh, boxes), 80u);
    EXPECT_LE(inner_area(bvh), before * (1.0 + 1e-6));
  }
}

TEST(CompileBvh, ReinsertionRespectsItsDepth) {
  const auto all = soups();
  const auto& soup = *std::ranges::find_if(all, [](const Soup& s) { return std::string(s.name) == "geometric row"; });
  const auto boxes = boxes_of(soup.primitives);
  Bvh bvh = build_bvh(boxes, {}, {.median_depth = 4});  // a flat tree that every move would deepen
  const std::uint32_t depth = check_binary(bvh, boxes);
  reinsert_subtrees(bvh, {.max_depth = depth});
  EXPECT_LE(check_binary(bvh, boxes), depth);
}

// A room of large walls around a cloud of small triangles: binned splits cut the cloud in the middle and leave pieces
// of the room in both halves.
TEST(CompileBvh, ReinsertionTakesLargePrimitivesOutOfTheWay) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-0.3f, 0.3f);
  std::vector<Box> boxes;
  for (int i = 0; i < 5000; ++i) {
    const float x = u(random), y = u(random);
    const glm::vec3 p(x, y, u(random));
    boxes.push_back({p, p + 0.005f});
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      Box wall{glm::vec3(-1.0f), glm::vec3(1.0f)};
      wall.lower[axis] = wall.upper[axis] = side;
      boxes.push_back(wall);
    }
  }
  Bvh bvh = build_bvh(boxes);
  const double before = inner_area(bvh);
  reinsert_subtrees(bvh);
  check_binary(bvh, boxes);
  EXPECT_LT(inner_area(bvh), 0.8 * before);
}

template <typename T, typename Allocator>
bool same_bytes(const std::vector<T, Allocator>& a, const std::vector<T, Allocator>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

bool same_tree(const WideBvh& a, const WideBvh& b) {
  return same_bytes(a.texels, b.texels) && same_bytes(a.slot_of, b.slot_of) && a.root == b.root && a.depth == b.depth;
}

TEST(CompileBvh, ThreadsDoNotChangeAByte) {
  const auto all = soups();
  const auto large = std::ranges::max_element(all, {}, [](const Soup& s) { return s.primitives.size(); });
  const auto boxes = boxes_of(large->primitives);
  const auto build = [&] {
    Bvh bvh = build_bvh(boxes);
    reinsert_subtrees(bvh);
    return bvh;
  };
  set_thread_count(1);
  const Bvh alone = build();
  const WideBvh alone_4 = make_wide_bvh<4>(alone, large->primitives);
  const WideBvh alone_8 = make_wide_bvh<8>(alone, large->primitives);
  for (const unsigned threads : {2u, 3u, 8u}) {
    set_thread_count(threads);
    const Bvh together = build();
    EXPECT_TRUE(same_bytes(alone.nodes, together.nodes)) << threads;
    EXPECT_TRUE(same_tree(alone_4, make_wide_bvh<4>(together, large->primitives))) << threads;
    EXPECT_TRUE(same_tree(alone_8, make_wide_bvh<8>(together, large->primitives))) << threads;
  }
  set_thread_count(0);
}

TEST(CompileBvh, SplitsLowerTheCost) {
  // Two far clusters: the root separates them, and a query that visits one never sees the other.
  std::vector<Box> boxes;
  std::mt19937 random(2);
  std::uniform_real_distribution<float> u(0.0f, 1.0f);
  for (int i = 0; i < 200; ++i) {
    const glm::vec3 p(u(random) + (i % 2 == 0 ? 0.0f : 50.0f), u(random), u(random));
    boxes.push_back({p, p + 0.01f});
  }
  const Bvh bvh = build_bvh(boxes);
  const BvhNode& root = bvh.nodes[0];
  const Box &left = bvh.nodes[root.first].box, &right = bvh.nodes[root.first + 1].box;
  EXPECT_TRUE(left.upper.x < 2.0f || right.upper.x < 2.0f);
  EXPECT_LT(left.half_area() + right.half_area(), 0.2f * root.box.half_area());
}

Bvh optimized_bvh(const std::vector<Box>& boxes) {
  Bvh bvh = build_bvh(boxes);
  reinsert_subtrees(bvh);
  return bvh;
}

template <typename Width>
class CompileWideBvh : public ::testing::Test {};
TYPED_TEST_SUITE(CompileWideBvh, test::TreeWidths, test::TreeWidthNames);

// Walks the wide tree by the slots that its nodes name.
template <std::uint32_t width>
struct WideCheck {
  const WideBvh& bvh;
  std::vector<int> seen;  // by primitive
  std::uint32_t depth = 0;

  explicit WideCheck(const WideBvh& tree) : bvh(tree), seen(tree.slot_of.size(), 0) {}
  void visit(std::uint32_t slot, std::uint32_t level) {
    using Layout = NodeLayout<width>;
    const TreeReader<width> tree(bvh.texels);
    if (!tree.is_node(slot)) {
      const auto primitive = std::ranges::find(bvh.slot_of, slot) - bvh.slot_of.begin();
      ASSERT_LT(static_cast<std::size_t>(primitive), seen.size());
      ++seen[primitive];
      return;
    }
    depth = std::max(depth, level + 1);
    ASSERT_GE(tree.child_count(slot), 2u);
    ASSERT_LE(tree.child_count(slot), width);
    ASSERT_EQ(tree.child_slot(slot, 0) * Layout::kSlotTexels % Layout::kGroupTexels, 0u);
    if (Layout::kNodeTexels == 4) {
      ASSERT_EQ(slot % 4, 0u) << "a node lies across two cache lines";
    }
    bool primitives = false;
    for (std::uint32_t i = 0; i < tree.child_count(slot); ++i) {
      const std::uint32_t child = tree.child_slot(slot, i);
      // A step of the walk loads as many texels of a primitive as of a node.
      ASSERT_LE(child * Layout::kSlotTexels + Layout::kNodeTexels, bvh.texels.size());
      if (Layout::kNodesFirst) {
        ASSERT_FALSE(primitives && tree.is_node(child));
      }
      primitives = primitives || !tree.is_node(child);
      visit(child, level + 1);
    }
  }
};

// The box of everything below a slot, from the primitives themselves.
template <std::uint32_t width>
Box exact_box(const WideBvh& bvh, const std::vector<gpu::Primitive>& primitives, std::uint32_t slot) {
  const TreeReader<width> tree(bvh.texels);
  Box box;
  if (!tree.is_node(slot)) {
    const gpu::Primitive p = tree.primitive(slot);
    using Bytes = std::array<std::byte, sizeof(gpu::Primitive)>;
    EXPECT_EQ(std::bit_cast<Bytes>(p), std::bit_cast<Bytes>(primitives.at(p.primitive)))
        << "a primitive's record is the primitive";
    return box_of(p);
  }
  for (std::uint32_t i = 0; i < tree.child_count(slot); ++i) {
    const Box child = exact_box<width>(bvh, primitives, tree.child_slot(slot, i));
    EXPECT_TRUE(contains(tree.child_box(slot, i), child)) << "slot " << slot << ", child " << i;
    box.extend(child);
  }
  for (std::uint32_t i = tree.child_count(slot); i < width; ++i) {
    const GridBox absent = tree.grid_box(slot, i);
    EXPECT_TRUE(glm::all(glm::greaterThan(absent.lower, absent.upper))) << "slot " << slot << ", child " << i;
  }
  return box;
}

TYPED_TEST(CompileWideBvh, NodesContainTheirChildrenAfterQuantisation) {
  constexpr std::uint32_t kWidth = TypeParam::value;
  for (const Soup& soup : soups()) {
    if (soup.primitives.size() > 5000) continue;
    SCOPED_TRACE(soup.name + std::string(", ") + std::to_string(soup.primitives.size()));
    const WideBvh tree = make_wide_bvh<kWidth>(optimized_bvh(boxes_of(soup.primitives)), soup.primitives);
    ASSERT_EQ(tree.slot_of.size(), soup.primitives.size());
    exact_box<kWidth>(tree, soup.primitives, tree.root);
    WideCheck<kWidth> check(tree);
    check.visit(tree.root, 0);
    EXPECT_TRUE(std::ranges::all_of(check.seen, [](int n) { return n == 1; }));
    EXPECT_EQ(check.depth, tree.depth);
    EXPECT_LE(tree.depth, gpu::kMaxTreeDepth);
  }
}

// Encoding and decoding are inverse for any node, wherever it lies.
TYPED_TEST(CompileWideBvh, ANodeReadsAsWritten) {
  constexpr std::uint32_t kWidth = TypeParam::value;
  using Layout = NodeLayout<kWidth>;
  std::mt19937 random(6);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  for (int round = 0; round < 20000; ++round) {
    Box box;
    for (int k = 0; k < 2; ++k) {
      const float x = u(random), y = u(random), size = std::exp2(-static_cast<float>(round % 33));
      box.extend(size * glm::vec3(x, y, u(random)) +
                 (round % 2 == 0 ? glm::vec3(0.0f) : glm::vec3(0.7f, -1.0f, 0.01f)));
    }
    if (round % 5 == 0) box.upper[round % 3] = box.lower[round % 3];
    const NodeGrid grid = Layout::fit_grid(box);
    ASSERT_TRUE(glm::all(glm::lessThanEqual(grid.origin, box.lower)));
    ASSERT_TRUE(glm::all(glm::greaterThanEqual(grid.origin + 255.0f * grid.scale, box.upper)));
    ASSERT_TRUE(contains(dequantize(grid, quantize(grid, box)), box));
    std::array<GridBox, kWidth> boxes;
    const std::uint32_t count = 2 + below(kWidth - 1);
    for (std::uint32_t i = 0; i < count; ++i) {
      boxes[i].lower = {below(256), below(256), below(256)};
      boxes[i].upper = {below(256), below(256), below(256)};
    }
    const auto groups = static_cast<std::uint32_t>(Layout::kMaxTexels / Layout::kGroupTexels);
    const ChildGroup group{below(groups) * Layout::kGroupTexels, count, Layout::kNodesFirst ? below(count) : 0};
    std::array<Texel, Layout::kNodeTexels> node;
    Layout::encode(grid, boxes, group, node.data());
    EXPECT_NE(node[0].w & gpu::kRecordNode, 0u);
    EXPECT_EQ(Layout::grid(node.data()).origin, grid.origin);
    EXPECT_EQ(Layout::grid(node.data()).scale, grid.scale);
    for (std::uint32_t i = 0; i < kWidth; ++i) {
      EXPECT_EQ(Layout::box(node.data(), i).lower, boxes[i].lower);
      EXPECT_EQ(Layout::box(node.data(), i).upper, boxes[i].upper);
    }
    EXPECT_EQ(Layout::group(node.data()).first_texel, group.first_texel);
    EXPECT_EQ(Layout::group(node.data()).count, group.count);
    EXPECT_EQ(Layout::group(node.data()).inner, group.inner);
  }
}

TEST(CompileNodeLayout, EightNodesAmongEightChildrenLieOneAfterTheOther) {
  const ChildGroup group{400, 8, 8};
  TexelVector texels(500, Texel(0u));
  NodeLayout<8>::encode(NodeLayout<8>::fit_grid({glm::vec3(0.0f), glm::vec3(1.0f)}), std::array<GridBox, 8>{}, group,
                        texels.data());
  const TreeReader<8> tree(texels);
  EXPECT_EQ(tree.child_count(0), 8u);
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(tree.child_slot(0, i), 400 + 4 * i);
}

TEST(CompileNodeLayout, CoordinatesBeyondTheGridAreRefused) {
  EXPECT_THROW(NodeLayout<8>::fit_grid({glm::vec3(-2.1f), glm::vec3(0.0f)}), Error);
  EXPECT_THROW(NodeLayout<8>::fit_grid({glm::vec3(0.0f), glm::vec3(2.0f)}), Error);
}

// A room of six walls around a cloud of small boxes.
std::vector<Box> room_and_cloud(std::size_t small) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> u(-0.3f, 0.3f);
  std::vector<Box> boxes;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      Box wall{glm::vec3(-1.0f), glm::vec3(1.0f)};
      wall.lower[axis] = wall.upper[axis] = side;
      boxes.push_back(wall);
    }
  }
  for (std::size_t i = 0; i < small; ++i) {
    const float x = u(random), y = u(random);
    const glm::vec3 p(x, y, u(random));
    boxes.push_back({p, p + 0.005f});
  }
  return boxes;
}

TEST(CompileFewPrimitives, WallsStandOutsideTheTree) {
  EXPECT_EQ(choose_few_primitives(room_and_cloud(1000)), (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5}));
}

TEST(CompileFewPrimitives, EqualPrimitivesStayInTheTree) {
  std::vector<Box> boxes = room_and_cloud(1000);
  boxes.erase(boxes.begin(), boxes.begin() + 6);
  EXPECT_TRUE(choose_few_primitives(boxes).empty());
}

TEST(CompileFewPrimitives, NeverMoreThanTheKernelsHold) {
  std::vector<Box> boxes;
  for (int i = 0; i < 40; ++i) {
    for (const Box& wall : room_and_cloud(0)) boxes.push_back(wall);
  }
  EXPECT_LE(choose_few_primitives(boxes).size(), gpu::kFewPrimitives);
  std::vector<Box> points(50, Box{glm::vec3(0.5f), glm::vec3(0.5f)});  // no areas at all
  EXPECT_LE(choose_few_primitives(points).size(), gpu::kFewPrimitives);
}

TEST(CompileFewPrimitives, SmallScenesHaveNoTree) {
  EXPECT_EQ(choose_few_primitives(room_and_cloud(gpu::kFewPrimitives - 6)).size(), gpu::kFewPrimitives);
}

TYPED_TEST(CompileWideBvh, FewPrimitivesComeFirstAndTheTreeHoldsTheRest) {
  constexpr std::uint32_t kWidth = TypeParam::value;
  std::vector<gpu::Primitive> primitives;
  for (const Box& box : room_and_cloud(1000)) {
    gpu::Primitive p{};
    p.p0 = box.lower, p.p1 = box.upper, p.p2 = {box.lower.x, box.upper.y, box.lower.z};
    p.primitive = static_cast<gpu::uint>(primitives.size());
    primitives.push_back(p);
  }
  const auto boxes = boxes_of(primitives);
  const std::vector<std::uint32_t> few = {2, 5, 700};
  const WideBvh tree = make_wide_bvh<kWidth>(build_bvh(boxes, few), primitives, few);
  const TreeReader<kWidth> reader(tree.texels);
  constexpr std::uint32_t kStride = kPrimitiveTexels / NodeLayout<kWidth>::kSlotTexels;
  EXPECT_GE(tree.root, 3 * kStride);
  EXPECT_LT(tree.root, 4 * kStride + 1);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(tree.slot_of[few[i]], i * kStride);
  WideCheck<kWidth> check(tree);
  check.visit(tree.root, 0);
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    EXPECT_EQ(check.seen[i], std::ranges::find(few, i) == few.end() ? 1 : 0) << i;
    EXPECT_EQ(reader.primitive(tree.slot_of[i]).primitive, i) << "a primitive's record is the primitive";
  }
}

TYPED_TEST(CompileWideBvh, QuantisedBoxesAreNotMuchLarger) {
  constexpr std::uint32_t kWidth = TypeParam::value;
  const auto all = soups();
  const auto& soup = *std::ranges::find_if(all, [](const Soup& s) { return s.primitives.size() == 3000; });
  const WideBvh bvh = make_wide_bvh<kWidth>(optimized_bvh(boxes_of(soup.primitives)), soup.primitives);
  const TreeReader<kWidth> tree(bvh.texels);
  // A grid of 255 steps per node is at most a factor of two too coarse (powers of two), plus one step to each side.
  std::vector<std::uint32_t> pending{bvh.root};
  while (!pending.empty()) {
    const std::uint32_t slot = pending.back();
    pending.pop_back();
    Box node;
    for (std::uint32_t i = 0; i < tree.child_count(slot); ++i) node.extend(tree.child_box(slot, i));
    for (std::uint32_t i = 0; i < tree.child_count(slot); ++i) {
      const std::uint32_t child = tree.child_slot(slot, i);
      if (tree.is_node(child)) {
        pending.push_back(child);
        continue;
      }
      const Box exact = box_of(tree.primitive(child)), coarse = tree.child_box(slot, i);
      const glm::vec3 slack = (coarse.upper - coarse.lower) - (exact.upper - exact.lower);
      for (int a = 0; a < 3; ++a) EXPECT_LE(slack[a], (node.upper[a] - node.lower[a]) * 4.1f / 255.0f + 1e-30f);
    }
  }
}

}  // namespace
}  // namespace etendue
