#pragma once
/// AOVs: depth, normals, object numbers. Each has a film of its own, from the same samples as the picture's;
/// docs/conventions.md, "AOVs".

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "image/film.h"

namespace etendue {

/// Files list them in this order.
enum class Aov : std::uint32_t {
  hit,  ///< share of the rays that hit something, by which others are divided; not in pictures
  alpha,
  depth,
  position,
  shading_normal,
  geometric_normal,
  uv,
  instance,
  primitive,
  material,
  normal,
  albedo,
  direct,
  indirect,
};

/// How the samples of a pixel become one value.
enum class AovMean {
  all,   ///< filtered, over all samples
  hits,  ///< over those that hit something, without the filter's weights
  first  ///< not averaged: the sample with the lowest index counts
};

struct AovTraits {
  Aov aov;
  const char* name;
  const char* channels;  ///< of its layer in a picture, one letter each; alpha is a channel of the picture itself
  AovMean mean;
  float missed;  ///< for AovMean::hits: the value without a hit
  const char* meaning;
};

std::span<const AovTraits> all_aovs();
const AovTraits& traits(Aov aov);
std::optional<Aov> aov_named(std::string_view name);
/// "depth, normal, albedo"; throws Error(usage) that lists the names for anything else.
std::vector<Aov> parse_aovs(std::string_view list);
/// The inverse.
std::string to_text(std::span<const Aov> aovs);
/// Sorted, without duplicates, and including what averages need.
std::vector<Aov> complete(std::vector<Aov> aovs);

struct AovFilm {
  Aov aov = Aov::hit;
  Film film;
};

/// Identifies an AOV in the header of a film.
struct AovHeader {
  Aov aov = Aov::hit;
  int exponent = 0;
  bool operator==(const AovHeader&) const = default;
};

/// Adds the samples of other films with the same AOVs; AOVs that are not averaged come from the film with the lowest
/// sample indices.
void merge_aovs(std::vector<AovFilm>& into, std::uint32_t lowest, const std::vector<AovFilm>& others,
                std::uint32_t others_lowest);

/// One additional channel of a picture: "depth.Z".
struct ImageChannel {
  std::string name;
  std::vector<float> values;
  std::vector<std::uint32_t> numbers;  ///< instead of values
};

/// "position.X", "position.Y", "position.Z"; empty for AOVs that are not in pictures.
std::vector<std::string> channel_names(Aov aov);
/// The channels that pictures contain, in the order of the AOVs.
std::vector<ImageChannel> channels_of(std::span<const AovFilm> aovs);

}  // namespace etendue
