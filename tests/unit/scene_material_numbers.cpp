/// Numbers of materials by name.

#include <algorithm>
#include <set>
#include <utility>
#include <variant>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/invariants.h"
#include "scene/material_numbers.h"
#include "scene/parameters.h"

namespace etendue {
namespace {

Material material_of(Bsdf bsdf) {
  Material material;
  material.bsdf = std::move(bsdf);
  material.name = "it";
  return material;
}

/// One of each kind.
std::vector<Material> all_kinds() {
  std::vector<Material> all;
  const auto add = [&]<std::size_t... I>(std::index_sequence<I...>) {
    (all.push_back(material_of(std::variant_alternative_t<I, Bsdf>{})), ...);
  };
  add(std::make_index_sequence<std::variant_size_v<Bsdf>>());
  for (const Adapter& adapter : {Adapter(TwoSidedAdapter{}), Adapter(MaskAdapter{}), Adapter(BlendAdapter{}),
                                 Adapter(NormalMapAdapter{}), Adapter(BumpMapAdapter{})})
    all.push_back({{}, adapter, "adapter", {}});
  return all;
}

TEST(MaterialNumbers, WhatIsSetIsRead) {
  std::set<std::string> types;
  for (Material material : all_kinds()) {
    EXPECT_TRUE(types.insert(type_name(material)).second) << type_name(material);
    double next = 0.25;
    for (const MaterialNumber& number : numbers_of(material)) {
      const glm::dvec3 wanted = number.is_color ? glm::dvec3(next, next + 1.0, next + 2.0) : glm::dvec3(next);
      ASSERT_TRUE(set_number(material, number.name, wanted)) << number.name;
      next += 4.0;
    }
    next = 0.25;
    for (const MaterialNumber& number : numbers_of(material)) {
      EXPECT_EQ(number.value.x, next) << type_name(material) << " " << number.name;
      EXPECT_EQ(number.value.z, number.is_color ? next + 2.0 : next) << number.name;
      EXPECT_FALSE(number.texture.has_value());
      next += 4.0;
    }
    EXPECT_FALSE(set_number(material, "nothing", {}));
  }
}

TEST(MaterialNumbers, NamesAreThoseOfTheFields) {
  std::vector<std::string> names;
  for (const MaterialNumber& number : numbers_of(material_of(RoughPlasticBsdf{}))) names.push_back(number.name);
  EXPECT_THAT(names,
              testing::ElementsAre("diffuse_reflectance", "specular_reflectance", "alpha", "int_ior", "ext_ior"));
  Material textured = material_of(DiffuseBsdf{});
  std::get<DiffuseBsdf>(textured.bsdf).albedo.texture = 3;
  EXPECT_EQ(numbers_of(textured).front().texture, 3u);
}

TEST(MaterialNumbers, OnlyNumbersMayBeExchanged) {
  const std::vector<Material> before = all_kinds();
  EXPECT_EQ(exchange_complaint(before, before), "");
  const auto complaint = [&](auto&& change) {
    std::vector<Material> after = before;
    change(after);
    return exchange_complaint(before, after);
  };
  EXPECT_EQ(complaint([](auto& all) { std::get<DiffuseBsdf>(all[0].bsdf).albedo.value = glm::dvec3(0.1); }), "");
  EXPECT_THAT(complaint([](auto& all) { all.pop_back(); }), testing::HasSubstr("18 materials in place of 19"));
  EXPECT_THAT(complaint([](auto& all) { all[0].bsdf = MirrorBsdf{}; }),
              testing::HasSubstr("is a mirror in place of a diffuse"));
  EXPECT_THAT(complaint([](auto& all) { std::get<DiffuseBsdf>(all[0].bsdf).albedo.texture = 0; }),
              testing::HasSubstr("other textures"));
  EXPECT_THAT(complaint([](auto& all) { std::get<PrincipledBsdf>(all[11].bsdf).anisotropic = 0.5; }),
              testing::HasSubstr("now lies along"));
}

TEST(MaterialNumbers, RangesAreThoseOfTheScene) {
  std::vector<Material> materials = {material_of(RoughPlasticBsdf{}), material_of(DielectricBsdf{})};
  const auto finding = [&] {
    Diagnostics diagnostics;
    check_materials(materials, diagnostics);
    return diagnostics.list().empty() ? "" : diagnostics.list().front().message;
  };
  EXPECT_EQ(finding(), "");
  set_number(materials[0], "alpha", glm::dvec3(1.5));
  EXPECT_THAT(finding(), testing::HasSubstr("the roughness 1.5 is not between"));
  set_number(materials[0], "alpha", glm::dvec3(0.5));
  set_number(materials[1], "specular_reflectance", {0.5, 2.0, 0.5});
  EXPECT_THAT(finding(), testing::HasSubstr("specular_reflectance 0.5 2 0.5 is not between 0 and 1"));
}

}  // namespace
}  // namespace etendue
