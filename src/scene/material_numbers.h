#pragma once
/// The numbers of a material by name: what may be changed while it is rendered.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace etendue {

struct MaterialNumber {
  std::string name;  ///< of the field in scene.h
  bool is_color = false;
  glm::dvec3 value{0.0};                 ///< of a number three times the same
  std::optional<std::uint32_t> texture;  ///< what it is multiplied with, an index into Scene::textures
};

/// Whether it is a texture of directions, which no factor makes sense for.
bool is_map(const MaterialNumber& number);

/// In the order of each_number(), of the material's own row alone.
std::vector<MaterialNumber> numbers_of(const Material& material);

/// Sets one of them; of a number the first component counts. False where there is none of that name. Whether the value
/// makes sense, check_materials() says.
bool set_number(Material& material, std::string_view name, const glm::dvec3& value);

/// The word that a scene file has for a material of this kind: "diffuse", "twosided".
std::string type_name(const Material& material);

/// Why a renderer of materials `before` cannot go on with `after` and compile nothing again; "" where it can: as many
/// of them, each of the same kind, with the same textures and choices, and turned about its normal as little as before
/// (is_aligned()).
std::string exchange_complaint(std::span<const Material> before, std::span<const Material> after);

}  // namespace etendue
