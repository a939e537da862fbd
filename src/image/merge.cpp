#include "image/merge.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"

namespace etendue {
namespace {

/// Metadata that must agree, because the samples depend on them.
struct IdentityKey {
  const char* key;
  const char* words;
};
constexpr std::array<IdentityKey, 4> kIdentity = {{{"version", "versions of the program"},
                                                   {"sceneHash", "scenes (sceneHash)"},
                                                   {"seed", "seeds"},
                                                   {"integrator", "integrator settings"}}};

/// Metadata that may differ from shard to shard and is then listed with its samples.
constexpr std::array<const char*, 2> kListed = {"device", "driver"};
constexpr const char* kUnknown = "unknown";

struct Shard {
  std::string path;
  FilmHeader header;
  const FilmFile* film = nullptr;  ///< null: in the file
};

std::string value_of(const Metadata& metadata, const std::string& key) {
  const auto found = metadata.find(key);
  constexpr std::size_t kMostShown = 120;  // an integrator with all its settings
  return found != metadata.end() ? fmt::format("\"{}\"", text::printable(found->second, kMostShown)) : "none";
}

[[noreturn]] void refuse(const std::string& a_name, const std::string& b_name, const char* what,
                         const std::string& a_value, const std::string& b_value) {
  throw Error(ErrorKind::file, fmt::format("{}: is not of the same render as {}: different {}, {} here and {} there",
                                           b_name, a_name, what, b_value, a_value));
}

std::string aov_names(const FilmHeader& header) {
  std::string list;
  for (const AovHeader& aov : header.aovs) list += fmt::format("{}{}", list.empty() ? "" : ",", traits(aov.aov).name);
  return list.empty() ? "none" : list;
}

/// One value of a listed key and the samples it stands for.
using Listed = std::map<std::string, SampleRanges>;

/// Reads "A [0:64]; B [64:128]". Names may contain anything, so the ranges must be those of the film or it is one plain
/// name.
std::optional<Listed> parse_list(const std::string& text, const SampleRanges& samples) {
  Listed entries;
  SampleRanges all;
  std::size_t start = 0;
  while (start < text.size()) {
    std::optional<SampleRanges> ranges;
    std::size_t open = start, close = start;
    while (!ranges) {
      open = text.find(" [", open + 1);
      close = open == std::string::npos ? open : text.find(']', open);
      if (close == std::string::npos) return {};
      const bool ends = close + 1 == text.size() || text.compare(close, 3, "]; ") == 0;
      if (ends) ranges = parse_sample_ranges(std::string_view(text).substr(open + 2, close - open - 2));
    }
    SampleRanges& entry = entries[text.substr(start, open - start)];
    entry.insert(entry.end(), ranges->begin(), ranges->end());
    all.insert(all.end(), ranges->begin(), ranges->end());
    start = close + 1 == text.size() ? text.size() : close + 3;
  }
  if (sample_count(all) != sample_count(samples) || canonical(all) != samples) return {};
  return entries;
}

/// The value of a listed key for the result; nothing if no shard has one.
std::optional<std::string> merge_listed(const std::vector<Shard>& shards, const char* key) {
  Listed entries;
  bool any = false;
  for (const Shard& shard : shards) {
    // The device of a film without samples does not matter, unless there are no others.
    if (shard.header.samples.empty() && !shards.front().header.samples.empty()) continue;
    const auto found = shard.header.metadata.find(key);
    any = any || found != shard.header.metadata.end();
    const std::string text = found != shard.header.metadata.end() ? found->second : kUnknown;
    const std::optional<Listed> list = parse_list(text, shard.header.samples);
    for (const auto& [name, ranges] : list ? *list : Listed{{text, shard.header.samples}}) {
      entries[name].insert(entries[name].end(), ranges.begin(), ranges.end());
    }
  }
  if (!any) return {};
  if (entries.size() == 1) return entries.begin()->first;
  std::vector<std::pair<SampleRanges, std::string>> ordered;
  for (const auto& [name, ranges] : entries) ordered.emplace_back(canonical(ranges), name);
  std::sort(ordered.begin(), ordered.end());
  std::string text;
  for (const auto& [ranges, name] : ordered)
    text += fmt::format("{}{} [{}]", text.empty() ? "" : "; ", name, to_text(ranges));
  return text;
}

Metadata merge_metadata(const std::vector<Shard>& shards) {
  Metadata result = shards.front().header.metadata;
  for (const Shard& shard : shards) {
    std::erase_if(result, [&](const auto& entry) {
      const auto found = shard.header.metadata.find(entry.first);
      return entry.first != "scene" && (found == shard.header.metadata.end() || found->second != entry.second);
    });
  }
  for (const char* key : kListed) {
    result.erase(key);
    if (const auto value = merge_listed(shards, key)) result[key] = *value;
  }
  return result;
}

/// Throws if two shards hold the same sample; returns the union.
SampleRanges join_ranges(const std::vector<Shard>& shards) {
  struct Owned {
    std::pair<std::uint32_t, std::uint32_t> range;
    const Shard* shard;
  };
  std::vector<Owned> owned;
  SampleRanges all;
  for (const Shard& shard : shards) {
    for (const auto& range : shard.header.samples) {
      owned.push_back({range, &shard});
      all.push_back(range);
    }
  }
  std::stable_sort(owned.begin(), owned.end(), [](const Owned& a, const Owned& b) { return a.range < b.range; });
  for (std::size_t i = 1; i < owned.size(); ++i) {
    const Owned &a = owned[i - 1], &b = owned[i];
    if (b.range.first < a.range.second) {
      throw Error(ErrorKind::file,
                  fmt::format("{} and {} both hold the samples {}:{}; give only one of them", a.shard->path,
                              b.shard->path, b.range.first, std::min(a.range.second, b.range.second)));
    }
  }
  return canonical(all);
}

/// Films without samples come last; they add nothing and name no device.
void sort_by_samples(std::vector<Shard>& shards) {
  std::stable_sort(shards.begin(), shards.end(), [](const Shard& a, const Shard& b) {
    if (a.header.samples.empty() || b.header.samples.empty())
      return !a.header.samples.empty() && b.header.samples.empty();
    return a.header.samples < b.header.samples;
  });
}

void add_film(FilmFile& sum, std::uint32_t& lowest, const FilmFile& film) {
  sum.film.merge(film.film);
  merge_aovs(sum.aovs, lowest, film.aovs, lowest_sample(film.samples));
  lowest = std::min(lowest, lowest_sample(film.samples));
}

FilmFile merge_shards(std::vector<Shard> shards) {
  if (shards.empty()) throw Error(ErrorKind::usage, "there is nothing to merge: give at least one film");
  for (const Shard& shard : shards)
    check_same_render(shards.front().header, shards.front().path, shard.header, shard.path);
  sort_by_samples(shards);
  FilmFile result;
  result.samples = join_ranges(shards);
  result.metadata = merge_metadata(shards);
  const FilmHeader& first = shards.front().header;
  result.film = Film(first.width, first.height, first.exponent);
  result.aovs = empty_aovs(first);
  std::uint32_t lowest = lowest_sample({});
  for (const Shard& shard : shards) {
    if (shard.film != nullptr) {
      add_film(result, lowest, *shard.film);
      continue;
    }
    const FilmFile file = read_film(shard.path);
    if (header_of(file) != shard.header) {
      throw Error(ErrorKind::file, fmt::format("{}: was changed while it was being merged; start again", shard.path));
    }
    add_film(result, lowest, file);
  }
  result.metadata = film_metadata(result);
  return result;
}

}  // namespace

void check_same_render(const FilmHeader& a, const std::string& a_name, const FilmHeader& b, const std::string& b_name) {
  for (const auto& [key, words] : kIdentity) {
    const std::string a_value = value_of(a.metadata, key), b_value = value_of(b.metadata, key);
    if (a_value != b_value) refuse(a_name, b_name, words, a_value, b_value);
  }
  if (a.width != b.width || a.height != b.height) {
    refuse(a_name, b_name, "sizes", fmt::format("{}x{}", a.width, a.height), fmt::format("{}x{}", b.width, b.height));
  }
  if (a.exponent != b.exponent) {
    refuse(a_name, b_name, "film exponents", std::to_string(a.exponent), std::to_string(b.exponent));
  }
  if (a.aovs != b.aovs) refuse(a_name, b_name, "AOVs (--aov)", aov_names(a), aov_names(b));
}

bool same_samples(const Metadata& a, const Metadata& b) {
  return std::all_of(kIdentity.begin(), kIdentity.end(), [&](const IdentityKey& identity) {
    const auto in_a = a.find(identity.key), in_b = b.find(identity.key);
    return in_a != a.end() && in_b != b.end() && in_a->second == in_b->second;
  });
}

FilmHeader merge_headers(const FilmHeader& a, const FilmHeader& b) {
  std::vector<Shard> shards = {{"one film", a}, {"the other film", b}};
  check_same_render(a, shards[0].path, b, shards[1].path);
  sort_by_samples(shards);
  FilmHeader result = shards.front().header;
  result.samples = join_ranges(shards);
  result.metadata = merge_metadata(shards);
  return result;
}

FilmFile merge_films(const std::vector<std::string>& paths) {
  std::vector<Shard> shards;
  for (const std::string& path : paths) shards.push_back({path, read_film_header(path)});
  return merge_shards(std::move(shards));
}

FilmFile merge_loaded_films(std::span<const FilmFile* const> films) {
  std::vector<Shard> shards;
  for (const FilmFile* film : films)
    shards.push_back({fmt::format("film {}", shards.size() + 1), header_of(*film), film});
  return merge_shards(std::move(shards));
}

}  // namespace etendue
