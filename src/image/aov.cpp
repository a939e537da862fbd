#include "image/aov.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "core/text.h"

namespace etendue {
namespace {

// The value that Blender writes where a ray leaves the scene, and that compositors treat as far away.
constexpr float kNoDepth = 1e10f;

constexpr std::array kAll = {
    AovTraits{Aov::hit, "hit", "", AovMean::all, 0, "share of the rays that hit something"},
    AovTraits{Aov::alpha, "alpha", "A", AovMean::all, 0, "coverage: 1 where a ray hits something, otherwise 0"},
    AovTraits{Aov::depth, "depth", "Z", AovMean::hits, kNoDepth, "distance from the camera, scene units"},
    AovTraits{Aov::position, "position", "XYZ", AovMean::hits, 0, "of what is met, world space"},
    AovTraits{Aov::shading_normal, "shading_normal", "XYZ", AovMean::all, 0,
              "of what is met, world space, maps included"},
    AovTraits{Aov::geometric_normal, "geometric_normal", "XYZ", AovMean::all, 0,
              "of the surface without vertex normals"},
    AovTraits{Aov::uv, "uv", "UV", AovMean::hits, 0, "texture coordinates, of the first set; 0 where there are none"},
    AovTraits{Aov::instance, "instance", "X", AovMean::first, 0,
              "number of the shape in the scene, from 1 on; 0: nothing"},
    AovTraits{Aov::primitive, "primitive", "X", AovMean::first, 0, "number of the triangle in its mesh, from 1 on"},
    AovTraits{Aov::material, "material", "X", AovMean::first, 0, "number of the material in the scene, from 1 on"},
    AovTraits{Aov::normal, "normal", "XYZ", AovMean::all, 0, "for denoisers: seen through mirrors and clear glass"},
    AovTraits{Aov::albedo, "albedo", "RGB", AovMean::all, 0,
              "for denoisers: reflectance, seen through mirrors and clear glass"},
    AovTraits{Aov::direct, "direct", "RGB", AovMean::all, 0, "light that was scattered once at most"},
    AovTraits{Aov::indirect, "indirect", "RGB", AovMean::all, 0, "light that was scattered more than once"},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kAll.size(); ++i) {
    if (static_cast<std::size_t>(kAll[i].aov) != i) return false;
  }
  return true;
}
static_assert(in_order());

std::string names() {
  std::string all;
  for (const AovTraits& row : kAll) {
    if (row.aov != Aov::hit) all += fmt::format("{}{}", all.empty() ? "" : ", ", row.name);
  }
  return all;
}

// Numbers come as two halves of 16 bits, which floats hold exactly.
std::uint32_t number_of(const glm::vec3& halves) {
  return static_cast<std::uint32_t>(halves.y) << 16 | static_cast<std::uint32_t>(halves.x);
}

std::string channel_name(const AovTraits& row, std::size_t channel) {
  const std::string letter(1, row.channels[channel]);
  return row.aov == Aov::alpha ? letter : fmt::format("{}.{}", row.name, letter);
}

ImageChannel numbers_of(const AovTraits& row, const Film& film) {
  ImageChannel out{.name = channel_name(row, 0)};
  out.numbers.resize(film.pixels().size());
  for (std::size_t i = 0; i < out.numbers.size(); ++i) out.numbers[i] = number_of(film.mean(i));
  return out;
}

/// `hits` is the film of the fraction of rays that hit something, if the average is over those.
void add_values(const AovTraits& row, const Film& film, const Film* hits, std::vector<ImageChannel>& out) {
  const std::size_t first = out.size(), count = std::string_view(row.channels).size();
  for (std::size_t c = 0; c < count; ++c) {
    out.push_back({.name = channel_name(row, c)});
    out.back().values.resize(film.pixels().size());
  }
  for (std::size_t i = 0; i < film.pixels().size(); ++i) {
    glm::vec3 value = film.mean(i);
    if (row.mean == AovMean::hits) {
      const float share = hits->mean(i).x;
      value = share > 0.0f ? glm::vec3(glm::dvec3(value) / static_cast<double>(share)) : glm::vec3(row.missed);
    }
    if (row.aov == Aov::alpha) value = glm::clamp(value, 0.0f, 1.0f);
    for (std::size_t c = 0; c < count; ++c) out[first + c].values[i] = value[static_cast<int>(c)];
  }
}

}  // namespace

std::span<const AovTraits> all_aovs() {
  return kAll;
}

const AovTraits& traits(Aov aov) {
  return kAll[static_cast<std::size_t>(aov)];
}

std::optional<Aov> aov_named(std::string_view name) {
  const auto found = std::ranges::find(kAll, name, &AovTraits::name);
  return found == kAll.end() ? std::nullopt : std::optional(found->aov);
}

std::vector<Aov> parse_aovs(std::string_view list) {
  std::vector<Aov> aovs;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    const std::string_view name = text::trim(list.substr(0, comma));
    const std::optional<Aov> aov = aov_named(name);
    if (!aov || aov == Aov::hit) {
      constexpr std::size_t kMostShown = 40;
      throw Error(ErrorKind::usage, fmt::format("'{}' is not an AOV; known are {}.",
                                                text::printable(std::string(name), kMostShown), names()));
    }
    aovs.push_back(*aov);
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
  return aovs;
}

std::string to_text(std::span<const Aov> aovs) {
  std::string list;
  for (const Aov aov : aovs) list += fmt::format("{}{}", list.empty() ? "" : ",", traits(aov).name);
  return list;
}

std::vector<Aov> complete(std::vector<Aov> aovs) {
  if (std::ranges::any_of(aovs, [](Aov aov) { return traits(aov).mean == AovMean::hits; })) aovs.push_back(Aov::hit);
  std::ranges::sort(aovs);
  aovs.erase(std::unique(aovs.begin(), aovs.end()), aovs.end());
  return aovs;
}

void merge_aovs(std::vector<AovFilm>& into, std::uint32_t lowest, const std::vector<AovFilm>& others,
                std::uint32_t others_lowest) {
  for (std::size_t i = 0; i < into.size(); ++i) {
    if (traits(into[i].aov).mean != AovMean::first) {
      into[i].film.merge(others[i].film);
    } else if (others_lowest < lowest) {
      into[i].film = others[i].film;
    }
  }
}

std::vector<std::string> channel_names(Aov aov) {
  const AovTraits& row = traits(aov);
  std::vector<std::string> names;
  for (std::size_t c = 0; c < std::string_view(row.channels).size(); ++c) names.push_back(channel_name(row, c));
  return names;
}

std::vector<ImageChannel> channels_of(std::span<const AovFilm> aovs) {
  std::vector<ImageChannel> out;
  const auto hits = std::ranges::find(aovs, Aov::hit, &AovFilm::aov);
  for (const AovFilm& aov : aovs) {
    const AovTraits& row = traits(aov.aov);
    if (row.mean == AovMean::hits && hits == aovs.end())
      throw std::logic_error("an AOV is averaged over hits that nobody has counted");
    if (row.mean == AovMean::first) {
      out.push_back(numbers_of(row, aov.film));
    } else {
      add_values(row, aov.film, hits == aovs.end() ? nullptr : &hits->film, out);
    }
  }
  return out;
}

}  // namespace etendue
