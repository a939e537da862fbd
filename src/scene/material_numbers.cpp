#include "scene/material_numbers.h"

#include <algorithm>
#include <concepts>
#include <iterator>
#include <type_traits>
#include <variant>

#include <fmt/format.h>

#include "core/text.h"
#include "scene/materials.h"
#include "scene/parameters.h"

namespace etendue {
namespace {

// In the order of the variants.
constexpr const char* kBsdfTypes[] = {
    "diffuse",        "mirror",  "dielectric",   "microfacet", "conductor",  "roughconductor", "roughdielectric",
    "thindielectric", "plastic", "roughplastic", "null",       "principled", "principledthin", "gltf"};
constexpr const char* kAdapterTypes[] = {"twosided", "mask", "blend", "normalmap", "bumpmap"};
static_assert(std::size(kBsdfTypes) == std::variant_size_v<Bsdf>);
static_assert(std::size(kAdapterTypes) == std::variant_size_v<Adapter>);

/// The parts of a material that must not change: its textures and their channels, and the rows that it chooses from.
std::vector<std::uint32_t> references_of(const Material& material) {
  std::vector<std::uint32_t> references;
  each_parameter(material, [&](const char*, const auto& parameter) {
    references.push_back(parameter.texture.value_or(~0u));
    if constexpr (requires { parameter.channel; })
      references.push_back(parameter.texture ? static_cast<std::uint32_t>(parameter.channel) : 0u);
  });
  if (material.adapter) each_choice(*material.adapter, [&](std::uint32_t row) { references.push_back(row); });
  return references;
}

}  // namespace

bool is_map(const MaterialNumber& number) {
  return number.texture && (number.name.ends_with("normals") || number.name.ends_with("directions"));
}

std::vector<MaterialNumber> numbers_of(const Material& material) {
  std::vector<MaterialNumber> numbers;
  each_number(material, [&](const char* name, const auto& number) {
    if constexpr (requires { number.texture; }) {
      const bool color = std::same_as<std::remove_cvref_t<decltype(number)>, ColorParameter>;
      numbers.push_back({name, color, glm::dvec3(number.value), number.texture});
    } else {
      const bool color = std::same_as<std::remove_cvref_t<decltype(number)>, glm::dvec3>;
      numbers.push_back({name, color, glm::dvec3(number), {}});
    }
  });
  return numbers;
}

bool set_number(Material& material, std::string_view name, const glm::dvec3& value) {
  bool found = false;
  each_number(material, [&](const char* own, auto& number) {
    if (name != own) return;
    found = true;
    const auto set = [&](auto& target) {
      if constexpr (std::same_as<std::remove_cvref_t<decltype(target)>, double>)
        target = value.x;
      else
        target = value;
    };
    if constexpr (requires { number.texture; })
      set(number.value);
    else
      set(number);
  });
  return found;
}

std::string type_name(const Material& material) {
  return material.adapter ? kAdapterTypes[material.adapter->index()] : kBsdfTypes[material.bsdf.index()];
}

std::string exchange_complaint(std::span<const Material> before, std::span<const Material> after) {
  if (before.size() != after.size())
    return fmt::format("there are {} materials in place of {}", after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Material &a = before[i], &b = after[i];
    const std::string name = text::quoted(a.name);
    if (type_name(a) != type_name(b))
      return fmt::format("{} is a {} in place of a {}", name, type_name(b), type_name(a));
    if (references_of(a) != references_of(b)) return fmt::format("{} has other textures or choices", name);
    if (is_aligned(a) != is_aligned(b))
      return fmt::format("{} {} along texture coordinates", name, is_aligned(b) ? "now lies" : "no longer lies");
  }
  return "";
}

}  // namespace etendue
