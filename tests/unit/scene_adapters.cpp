/// Adapters as data: what may stand in what, and what a scene's hash knows of them.

#include <gmock/gmock.h>

#include "core/errors.h"
#include "scene/invariants.h"
#include "scene/limits.h"
#include "scene/materials.h"

namespace etendue {
namespace {

using ::testing::HasSubstr;

/// A sphere whose material is the last of `materials`.
Scene sphere_of(std::vector<Material> materials) {
  Scene scene;
  scene.materials = std::move(materials);
  scene.shapes.emplace_back(Sphere{});
  scene.instances.push_back({.material = static_cast<std::uint32_t>(scene.materials.size() - 1), .name = "ball"});
  return scene;
}

void expect_refused(const Scene& scene, const std::string& words) {
  try {
    require_invariants(scene);
    ADD_FAILURE() << "accepted; expected " << words;
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
}

const Material kGrey{.bsdf = DiffuseBsdf{}, .name = "grey"};
const Material kGlass{.bsdf = DielectricBsdf{}, .name = "glass"};

TEST(SceneAdapters, NestAndReferToEarlierRows) {
  require_invariants(sphere_of({kGrey,
                                {.adapter = TwoSidedAdapter{0, 0}, .name = "sheet"},
                                {.adapter = MaskAdapter{0.3, 1}, .name = "leaf"},
                                {.adapter = BlendAdapter{0.5, 0, 2}, .name = "mixture"}}));
  expect_refused(sphere_of({{.adapter = MaskAdapter{0.3, 0}, .name = "leaf"}}), "it can refer only to earlier ones");
  expect_refused(sphere_of({kGrey, {.adapter = BlendAdapter{0.3, 0, 7}, .name = "leaf"}}), "number 7");
  expect_refused(sphere_of({kGrey, {.adapter = MaskAdapter{1.5, 0}, .name = "leaf"}}), "opacity 1.5");
  expect_refused(sphere_of({kGrey, {.adapter = BlendAdapter{-0.5, 0, 0}, .name = "leaf"}}), "weight -0.5");
}

TEST(SceneAdapters, HaveALimitOfDepth) {
  std::vector<Material> rows{kGrey};
  for (std::uint32_t i = 0; i < kMaxAdapterDepth; ++i) rows.push_back({.adapter = MaskAdapter{0.5, i}, .name = "leaf"});
  require_invariants(sphere_of(rows));
  rows.push_back({.adapter = MaskAdapter{0.5, kMaxAdapterDepth}, .name = "leaf"});
  expect_refused(sphere_of(rows), "at most 16");
}

TEST(SceneAdapters, WhatLetsLightThroughHasNoBack) {
  const Material sheet{.adapter = TwoSidedAdapter{0, 1}, .name = "sheet"};
  expect_refused(sphere_of({kGrey, kGlass, sheet}), "\"glass\" transmits light");
  expect_refused(sphere_of({kGrey, {.bsdf = NullBsdf{}, .name = "air"}, sheet}), "\"air\" transmits light");
  expect_refused(sphere_of({kGrey, {.adapter = MaskAdapter{0.5, 0}, .name = "leaf"}, sheet}),
                 "\"leaf\" transmits light");
  require_invariants(sphere_of({kGrey, kGrey, sheet}));
}

TEST(SceneAdapters, AreReachedOnceEach) {
  const Scene scene = sphere_of({kGrey,
                                 kGlass,
                                 {.adapter = BlendAdapter{0.5, 0, 0}, .name = "a"},
                                 {.adapter = BlendAdapter{0.5, 2, 0}, .name = "b"}});
  std::vector<std::string> names;
  each_material(scene, 3, [&](const Material& material) { names.push_back(material.name); });
  EXPECT_THAT(names, ::testing::ElementsAre("b", "a", "grey"));
  EXPECT_FALSE(may_pass(scene));
  EXPECT_TRUE(may_pass(sphere_of({kGrey, {.adapter = MaskAdapter{0.5, 0}, .name = "leaf"}})));
  EXPECT_TRUE(may_pass(sphere_of({{.bsdf = NullBsdf{}, .name = "air"}})));
}

TEST(SceneAdapters, AreInTheHash) {
  const auto hash = [](const Adapter& adapter, const Material& first = kGrey) {
    return scene_hash(sphere_of({first, kGlass, {.adapter = adapter, .name = "x"}}));
  };
  const std::uint64_t mask = hash(MaskAdapter{0.5, 0});
  EXPECT_EQ(mask, hash(MaskAdapter{0.5, 0}));
  EXPECT_NE(mask, hash(MaskAdapter{0.4, 0}));
  EXPECT_NE(mask, hash(MaskAdapter{0.5, 1}));
  EXPECT_NE(mask, hash(BlendAdapter{0.5, 0, 0}));
  EXPECT_NE(mask, hash(MaskAdapter{0.5, 0}, {.bsdf = DiffuseBsdf{glm::dvec3(0.25)}, .name = "grey"}));
  EXPECT_NE(mask, scene_hash(sphere_of({kGrey})));
}

}  // namespace
}  // namespace etendue
