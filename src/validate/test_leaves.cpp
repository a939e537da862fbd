#include "validate/test_leaves.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "core/errors.h"
#include "reference/scatterer.h"
#include "reference/test_patch.h"

namespace etendue {
namespace {

constexpr std::uint32_t kExampleSamples = 1u << 20;  // samples among which examples of rare outcomes are looked for

constexpr double kRoundedDirection = 1e-6;  // a device has single precision

bool same_place(const reference::ChosenMaterial& a, const reference::ChosenMaterial& b) {
  const glm::dvec3 probe(0.3, 0.5, 0.7);
  return a.row == b.row && a.base == b.base && a.shadowed == b.shadowed && a.side == b.side &&
         a.frame.to_world(probe) == b.frame.to_world(probe);
}

/// What the material of a patch without adapters comes to.
const Material& material_of(const Scene& patch) {
  return patch.materials[patch.instances.front().material];
}

}  // namespace

TestLeaves::TestLeaves(const Scene& patch, const glm::dvec3& wo, std::uint32_t resolution, std::uint32_t seed)
    : patch_(patch),
      wo_(wo),
      seed_(seed),
      surface_(reference::patch_surface()),
      outcomes_(patch, surface_, -wo),
      examples_(outcomes_.all().size()),
      leaf_of_(outcomes_.all().size()),
      pair_of_(outcomes_.all().size()) {
  if (!outcomes_.complete()) {
    throw Error(ErrorKind::usage,
                fmt::format("{} may come to more than {} combinations of its masks and blends, which is too many to "
                            "test; test its parts on their own",
                            material_of(patch).name, reference::Outcomes::kMost));
  }
  find_examples();
  find_leaves(resolution);
  find_pairs();
}

std::size_t TestLeaves::outcome_of(std::uint32_t sample) const {
  if (outcomes_.all().size() == 1) return 0;
  const reference::SampleRandom random(seed_, 0, sample);
  reference::RandomDecider decider(surface_, -wo_, random, 0, false);
  return outcomes_.of(decider);
}

void TestLeaves::find_examples() {
  std::size_t missing = examples_.size();
  for (std::uint32_t i = 0; i < kExampleSamples && missing > 0; ++i) {
    std::optional<std::uint32_t>& example = examples_[outcome_of(i)];
    if (example) continue;
    example = i;
    --missing;
  }
}

TestLeaf TestLeaves::make_leaf(const reference::ChosenMaterial& chosen, std::uint32_t resolution) const {
  Bsdf bsdf = reference::material_at(patch_, chosen, surface_, -wo_);
  const reference::Scatterer scatterer(bsdf, chosen, wo_);
  const glm::dvec3 wo = chosen.frame.to_local(wo_);
  std::vector<DeltaLobe> lobes = delta_lobes(bsdf, wo);
  for (DeltaLobe& lobe : lobes) lobe.weight *= scatterer.carried(chosen.frame.to_world(lobe.wi));
  SampleCounts counts(SampleGrid(bsdf, wo, resolution), std::move(lobes));
  return {.chosen = chosen, .bsdf = bsdf, .black = adapted() && scatterer.black(), .counts = std::move(counts)};
}

void TestLeaves::find_leaves(std::uint32_t resolution) {
  for (std::size_t i = 0; i < outcomes_.all().size(); ++i) {
    const reference::Outcome& outcome = outcomes_.all()[i];
    std::optional<reference::ChosenMaterial> chosen;
    if (outcome.materials) chosen = outcome.materials->chosen;
    if (!material_of(patch_).adapter) chosen = reference::plain_material(patch_, surface_);
    if (!chosen) {
      passing_ += outcome.probability;
      continue;
    }
    const auto known = std::ranges::find_if(leaves_, [&](const TestLeaf& l) { return same_place(l.chosen, *chosen); });
    leaf_of_[i] = static_cast<std::size_t>(known - leaves_.begin());
    if (known == leaves_.end()) leaves_.push_back(make_leaf(*chosen, resolution));
    TestLeaf& leaf = leaves_[*leaf_of_[i]];
    leaf.probability += outcome.probability;
    if (!leaf.example) leaf.example = examples_[i];
  }
}

void TestLeaves::find_pairs() {
  using Decisions = std::vector<std::pair<std::uint32_t, bool>>;
  std::map<std::pair<std::optional<std::uint32_t>, Decisions>, std::size_t> known;
  for (std::size_t i = 0; i < outcomes_.all().size(); ++i) {
    const reference::Outcome& outcome = outcomes_.all()[i];
    Decisions others = outcome.decisions;
    std::optional<std::uint32_t> blend;
    if (outcome.materials) blend = outcome.materials->blend;
    std::erase_if(others, [&](const auto& decision) { return decision.first == blend; });
    std::ranges::sort(others);
    pair_of_[i] = known.emplace(std::pair(blend, std::move(others)), pairs_.size()).first->second;
    if (pair_of_[i] == pairs_.size()) pairs_.emplace_back();
    Pair& pair = pairs_[pair_of_[i]];
    pair.outcomes.push_back(i);
    pair.complete = pair.complete && examples_[i].has_value();
  }
}

bool TestLeaves::adapted() const {
  return material_of(patch_).adapter.has_value();
}

void TestLeaves::add(const BsdfDraw& draw, std::uint32_t sample) {
  if (draw.lobe == ProbeLobe::passed && glm::distance(draw.wi, -wo_) < kRoundedDirection &&
      draw.weight == glm::dvec3(1.0)) {
    ++passed_;
    return;
  }
  const std::optional<std::size_t> leaf = leaf_of(sample);
  if (!leaf) {
    ++unforeseen_;
    return;
  }
  BsdfDraw local = draw;
  local.wi = leaves_[*leaf].chosen.frame.to_local(draw.wi);
  leaves_[*leaf].counts.add(local);
}

}  // namespace etendue
