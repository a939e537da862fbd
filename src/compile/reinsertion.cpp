#include "compile/reinsertion.h"

#include <algorithm>
#include <queue>
#include <utility>

#include "core/long_task.h"
#include "core/parallel.h"

namespace etendue {
namespace {

constexpr std::uint32_t kNowhere = ~0u;

Box merged(const Box& a, const Box& b) {
  Box box = a;
  box.extend(b);
  return box;
}

// Moves the subtree `from` beside the subtree `to`, which saves `gain` of the summed area of boxes.
struct Move {
  std::uint32_t from = kNowhere, to = kNowhere;
  float gain = 0.0f;
};

class Optimizer {
 public:
  Optimizer(Bvh& bvh, const ReinsertionConfig& config)
      : nodes_(bvh.nodes), config_(config), parents_(nodes_.size(), kNowhere), heights_(nodes_.size(), 0) {
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) adopt_children(i);
    for (auto i = static_cast<std::uint32_t>(nodes_.size()); i-- > 0;)
      update_height(i);  // children come after their parent
  }

  void run() {
    // Large boxes come first, because every ray meets them, and one by one, because a move there changes the gain of
    // the next.
    for (std::uint32_t pass = 0; pass < config_.large_passes; ++pass) {
      if (move_one_by_one(largest(config_.large)) == 0) break;
    }
    const auto share = static_cast<std::size_t>(config_.share * static_cast<float>(nodes_.size()));
    LongTask progress("Improving the tree", config_.rounds);
    for (std::uint32_t round = 0; round < config_.rounds; ++round, progress.advance(1)) {
      if (apply(find_moves(largest(std::max<std::size_t>(share, config_.at_least)))) == 0) break;
    }
  }

 private:
  void adopt_children(std::uint32_t node) {
    if (nodes_[node].leaf == 0) parents_[nodes_[node].first] = parents_[nodes_[node].first + 1] = node;
  }
  void update_height(std::uint32_t node) {
    const BvhNode& n = nodes_[node];
    if (n.leaf == 0) heights_[node] = static_cast<std::uint8_t>(1 + std::max(heights_[n.first], heights_[n.first + 1]));
  }

  // The nodes with the largest boxes, largest first, without the root. No box is larger than its parent's, so a walk
  // that always goes on at the largest meets them in that order and leaves most of the tree alone.
  std::vector<std::uint32_t> largest(std::size_t count) const {
    using Sized = std::pair<float, std::uint32_t>;
    const auto sized = [&](std::uint32_t node) { return Sized{nodes_[node].box.half_area(), node}; };
    std::vector<Sized> found;
    std::priority_queue<Sized> next;
    const auto push_children = [&](std::uint32_t node) {
      for (const std::uint32_t child : {nodes_[node].first, nodes_[node].first + 1}) next.push(sized(child));
    };
    push_children(0);
    // All that are as large as the last one: their numbers decide which of these count.
    while (!next.empty() && (found.size() < count || next.top().first == found.back().first)) {
      found.push_back(next.top());
      next.pop();
      if (nodes_[found.back().second].leaf == 0) push_children(found.back().second);
    }
    std::ranges::sort(found, [](const Sized& a, const Sized& b) {
      return a.first != b.first ? a.first > b.first : a.second < b.second;
    });
    std::vector<std::uint32_t> all;
    for (std::size_t i = 0; i < std::min(count, found.size()); ++i) all.push_back(found[i].second);
    return all;
  }

  std::size_t move_one_by_one(const std::vector<std::uint32_t>& candidates) {
    std::size_t made = 0;
    for (const std::uint32_t from : candidates) {
      const Move move = find_move(from);
      if (move.to == kNowhere || !fits(move)) continue;
      make(move);
      ++made;
    }
    return made;
  }

  // The best move of each candidate in the unchanged tree; the most profitable first.
  std::vector<Move> find_moves(const std::vector<std::uint32_t>& candidates) const {
    std::vector<Move> moves(candidates.size());
    parallel_for(candidates.size(), 64, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i) moves[i] = find_move(candidates[i]);
    });
    std::erase_if(moves, [](const Move& m) { return m.to == kNowhere; });
    std::ranges::sort(
        moves, [](const Move& a, const Move& b) { return a.gain != b.gain ? a.gain > b.gain : a.from < b.from; });
    return moves;
  }

  // Walks from `from` up to the root, and from each sibling on the way down again. `freed` is the area saved so far:
  // that of the parent, which disappears, and that by which boxes on the way up shrink. On the way down boxes grow,
  // which limits what can still be gained there.
  Move find_move(std::uint32_t from) const {
    Move best{.from = from};
    const Box& moved = nodes_[from].box;
    const float moved_area = moved.half_area();
    const std::uint32_t parent = parents_[from];
    std::uint32_t sibling = bvh_sibling(from);
    float freed = nodes_[parent].box.half_area();
    Box rest = nodes_[sibling].box;  // the box of `up` without `from`
    for (std::uint32_t up = parent;;) {
      search_below(sibling, freed, moved, moved_area, best);
      if (up != parent) {
        rest.extend(nodes_[sibling].box);
        freed += nodes_[up].box.half_area() - rest.half_area();
      }
      if (up == 0) break;
      sibling = bvh_sibling(up);
      up = parents_[up];
    }
    return best;
  }

  void search_below(std::uint32_t root, float freed, const Box& moved, float moved_area, Move& best) const {
    struct Entry {
      std::uint32_t node;
      float freed;
    };
    thread_local std::vector<Entry> pending;
    pending.assign(1, {root, freed});
    while (!pending.empty()) {
      const Entry e = pending.back();
      pending.pop_back();
      if (e.freed - moved_area <= best.gain) continue;
      const BvhNode& node = nodes_[e.node];
      const float gain = e.freed - merged(node.box, moved).half_area();
      if (gain > best.gain) {
        best.to = e.node;
        best.gain = gain;
      }
      if (node.leaf != 0) continue;
      const float below = gain + node.box.half_area();
      pending.push_back({node.first, below});
      pending.push_back({node.first + 1, below});
    }
  }

  // Carries out the moves that touch no node of an earlier one; returns their number.
  std::size_t apply(const std::vector<Move>& moves) {
    std::vector<bool> touched(nodes_.size(), false);
    std::size_t made = 0;
    for (const Move& move : moves) {
      const std::uint32_t sibling = bvh_sibling(move.from), parent = parents_[move.from];
      if (touched[move.from] || touched[move.to] || touched[sibling] || touched[parent]) continue;
      if (!fits(move)) continue;
      for (const std::uint32_t node : {move.from, move.to, sibling, parent}) touched[node] = true;
      make(move);
      ++made;
    }
    return made;
  }

  // Returns false if earlier moves have put the target into the subtree to be moved, or if the tree would become too
  // deep.
  bool fits(const Move& move) const {
    std::uint32_t depth = 1;  // depth of the pair that takes the target's place
    for (std::uint32_t node = move.to; node != 0; node = parents_[node]) {
      if (node == move.from) return false;
      ++depth;
    }
    return depth + std::max(heights_[move.from], heights_[move.to]) <= config_.max_depth;
  }

  // The sibling takes its parent's place. The pair that it leaves takes the target's place: one of it becomes the
  // target, the other the moved subtree.
  void make(const Move& move) {
    const std::uint32_t sibling = bvh_sibling(move.from), parent = parents_[move.from];
    nodes_[parent] = nodes_[sibling];
    heights_[parent] = heights_[sibling];
    adopt_children(parent);
    nodes_[sibling] = nodes_[move.to];
    heights_[sibling] = heights_[move.to];
    adopt_children(sibling);
    nodes_[move.to].leaf = 0;
    nodes_[move.to].first = std::min(move.from, sibling);
    adopt_children(move.to);
    if (parent != 0) refit(parents_[parent]);
    refit(move.to);
  }

  void refit(std::uint32_t node) {
    for (;; node = parents_[node]) {
      const std::uint32_t first = nodes_[node].first;
      nodes_[node].box = merged(nodes_[first].box, nodes_[first + 1].box);
      update_height(node);
      if (node == 0) return;
    }
  }

  std::vector<BvhNode>& nodes_;
  ReinsertionConfig config_;
  std::vector<std::uint32_t> parents_;
  std::vector<std::uint8_t> heights_;  // levels below a node
};

}  // namespace

void reinsert_subtrees(Bvh& bvh, const ReinsertionConfig& config) {
  if (bvh.nodes.size() > 3) Optimizer(bvh, config).run();
}

}  // namespace etendue
