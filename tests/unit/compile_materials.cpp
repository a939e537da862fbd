/// Where parameters of materials lie in their records.

#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "compile/material_records.h"
#include "scene/parameters.h"

namespace etendue {
namespace {

template <typename T>
struct TypesOf;
template <typename... Ts>
struct TypesOf<std::variant<Ts...>> {
  template <typename F>
  static void each(F&& f) {
    (f(Ts{}), ...);
  }
};

// Bits of the floats that the texture of each parameter is multiplied with, by the parameter's name.
std::map<std::string, gpu::uint> floats_by_name(Bsdf bsdf) {
  std::vector<std::string> names;
  each_parameter(bsdf, [&](const char* name, auto& parameter) {
    parameter.texture = 0;
    names.emplace_back(name);
  });
  Material material;
  material.bsdf = bsdf;
  std::vector<gpu::TextureUse> uses;
  material_textures(material, uses);
  std::map<std::string, gpu::uint> floats;
  for (std::size_t i = 0; i < uses.size(); ++i) floats[names.at(i)] = uses[i].floats;
  return floats;
}

TEST(MaterialRecords, EveryParameterHasFloatsOfItsOwn) {
  TypesOf<Bsdf>::each([](const auto& type) {
    const Bsdf bsdf = type;
    gpu::uint taken = 0;
    for (const auto& [name, floats] : floats_by_name(bsdf)) {
      EXPECT_NE(floats, 0u) << name;
      EXPECT_EQ(taken & floats, 0u) << name << " shares floats, material " << bsdf.index();
      taken |= floats;
    }
  });
}

}  // namespace
}  // namespace etendue
