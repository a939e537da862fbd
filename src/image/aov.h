#pragma once
/// What is rendered beside a picture: depth, normals, numbers of things. Each is a film of its own, of the same samples
/// as the picture's; docs/conventions.md, "AOVs".

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
  hit,  ///< share of the rays that hit something: others are averaged by it; in no picture
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
  all,   ///< by the filter, over all samples
  hits,  ///< over those that meet something, without the filter's weights
  first  ///< not at all: the sample of the lowest index counts
};

struct AovTraits {
  Aov aov;
  const char* name;
  const char* channels;  ///< of its layer in a picture, a letter each; alpha is a channel of the picture itself
  AovMean mean;
  float missed;  ///< of AovMean::hits: the value where nothing was met
  const char* meaning;
};

std::span<const AovTraits> all_aovs();
const AovTraits& traits(Aov aov);
std::optional<Aov> aov_named(std::string_view name);
/// "depth, normal, albedo"; throws Error(usage) that lists the names for anything else.
std::vector<Aov> parse_aovs(std::string_view list);
/// The inverse.
std::string to_text(std::span<const Aov> aovs);
/// Sorted, without repetitions, and with what the averages of others need.
std::vector<Aov> complete(std::vector<Aov> aovs);

struct AovFilm {
  Aov aov = Aov::hit;
  Film film;
};

/// What identifies one in the header of a film.
struct AovHeader {
  Aov aov = Aov::hit;
  int exponent = 0;
  bool operator==(const AovHeader&) const = default;
};

/// Adds the samples of other films of the same AOVs; what is not averaged comes from the lower one of the lowest sample
/// indices.
void merge_aovs(std::vector<AovFilm>& into, std::uint32_t lowest, const std::vector<AovFilm>& others,
                std::uint32_t others_lowest);

/// One channel of a picture beside its colour: "depth.Z".
struct ImageChannel {
  std::string name;
  std::vector<float> values;
  std::vector<std::uint32_t> numbers;  ///< instead of values
};

/// "position.X", "position.Y", "position.Z"; none of what no picture has.
std::vector<std::string> channel_names(Aov aov);
/// What pictures show of the films, in the order of the AOVs.
std::vector<ImageChannel> channels_of(std::span<const AovFilm> aovs);

}  // namespace etendue
