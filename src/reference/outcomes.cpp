#include "reference/outcomes.h"

#include <algorithm>

namespace etendue::reference {
namespace {

constexpr std::uint32_t kOutcome = UINT32_MAX;

/// Repeats given decisions; notes the first one that is missing.
class Script final : public Decider {
 public:
  explicit Script(const std::vector<std::pair<std::uint32_t, bool>>& decisions) : decisions_(decisions) {}
  bool happens(std::uint32_t row, double probability) override {
    for (const auto& [known, happened] : decisions_)
      if (known == row) return happened;
    if (!missing) missing = {row, probability};
    return true;
  }
  std::optional<std::pair<std::uint32_t, double>> missing = {};

 private:
  const std::vector<std::pair<std::uint32_t, bool>>& decisions_;
};

}  // namespace

Outcomes::Outcomes(const Scene& scene, const Surface& surface, const Vec3& d) {
  root_ = explore(scene, surface, d, {.probability = 1.0, .decisions = {}, .materials = {}});
}

std::size_t Outcomes::explore(const Scene& scene, const Surface& surface, const Vec3& d, Outcome prefix) {
  Script script(prefix.decisions);
  std::optional<ChosenMaterials> materials = choose_materials(scene, surface, d, script);
  const std::size_t node = nodes_.size();
  if (!script.missing || outcomes_.size() >= kMost) {
    complete_ = complete_ && !script.missing;
    prefix.materials = std::move(materials);
    nodes_.push_back({kOutcome, 0.0, outcomes_.size(), 0});
    outcomes_.push_back(std::move(prefix));
    return node;
  }
  const auto [row, probability] = *script.missing;
  nodes_.push_back({row, probability, 0, 0});
  const auto branch = [&](bool happens, double share) {
    Outcome next = prefix;
    next.probability *= share;
    next.decisions.emplace_back(row, happens);
    return explore(scene, surface, d, std::move(next));
  };
  const double share = std::clamp(probability, 0.0, 1.0);
  const std::size_t yes = share > 0.0 ? branch(true, share) : 0;
  const std::size_t no = share < 1.0 ? branch(false, 1.0 - share) : 0;
  nodes_[node].happens = yes;
  nodes_[node].otherwise = no;
  return node;
}

std::size_t Outcomes::of(Decider& decider) const {
  const Node* node = &nodes_[root_];
  while (node->row != kOutcome)
    node = &nodes_[decider.happens(node->row, node->probability) ? node->happens : node->otherwise];
  return node->happens;
}

}  // namespace etendue::reference
