#include "formats/mitsuba/features.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace etendue {
namespace {

constexpr std::size_t kListedPlaces = 5;

}  // namespace

void MissingFeatures::add(const std::string& what, const SourcePosition& position, const std::string& substitute) {
  Feature& feature = features_[what];
  const auto is_here = [&](const SourcePosition& place) {
    return place.file == position.file && place.line == position.line && place.column == position.column;
  };
  if (std::ranges::any_of(feature.places, is_here)) return;
  if (feature.count++ == 0) feature.substitute = substitute;
  if (feature.places.size() < kListedPlaces) feature.places.push_back(position);
}

std::string MissingFeatures::places_of(const Feature& feature) const {
  std::vector<std::string> places;
  for (const SourcePosition& place : feature.places) places.push_back(to_string(place));
  std::string text = fmt::format("{}", fmt::join(places, ", "));
  if (feature.count > places.size()) text += fmt::format(" and {} more", feature.count - places.size());
  return text;
}

void MissingFeatures::report(const SourcePosition& scene, Diagnostics& diagnostics) const {
  if (features_.empty()) return;
  if (approximate_) {
    for (const auto& [what, feature] : features_)
      diagnostics.warning(feature.places.front(),
                          fmt::format("{} is approximated: {} ({})", what, feature.substitute, places_of(feature)));
    return;
  }
  std::vector<std::string> list;
  for (const auto& [what, feature] : features_) list.push_back(fmt::format("{} ({})", what, places_of(feature)));
  diagnostics.error(scene, fmt::format("the scene needs things that are not supported: {}", fmt::join(list, "; ")));
}

std::vector<std::string> MissingFeatures::substitutes() const {
  std::vector<std::string> list;
  for (const auto& [what, feature] : features_) list.push_back(fmt::format("{}: {}", what, feature.substitute));
  return list;
}

}  // namespace etendue
