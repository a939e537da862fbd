#include "validate/score_spread.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "core/parallel.h"
#include "validate/mean_difference.h"

namespace etendue {
namespace {

constexpr double kSecondMoment = 3.0;   // of a squared normal score, which no other has more of
constexpr double kAllowedExcess = 2.0;  // variances up to so many times too large are nobody's fault

/// Sums over the pixels of a tile.
struct TileSum {
  double squares = 0;
  std::uint64_t pixels = 0;
  double mean() const { return pixels == 0 ? 0.0 : squares / static_cast<double>(pixels); }
  bool below_chance(double level) const {
    return pixels > 0 && mean_lower_tail_bound(kAllowedExcess * mean(), pixels, kSecondMoment) < level;
  }
};

/// Mean over the channels that have a score; channels share their samples, so that a pixel counts once.
void add_pixel(const Image& test, const Image& reference, std::size_t pixel, TileSum& sum) {
  if (!testable(test, pixel, 2) || !testable(reference, pixel, 2)) return;
  double squares = 0;
  int scores = 0;
  for (int channel = 0; channel < 3; ++channel) {
    MeanDifference difference;
    difference.add(test, reference, pixel, channel);
    const double square = difference.square();
    if (!(square >= 0.0)) continue;  // NaN is judged by the tests
    squares += square;
    ++scores;
  }
  if (scores == 0) return;
  sum.squares += squares / scores;
  ++sum.pixels;
}

}  // namespace

ScoreSpread score_spread(const Image& test, const Image& reference) {
  const std::uint32_t columns = (test.width + kSpreadTile - 1) / kSpreadTile;
  const std::uint32_t rows = (test.height + kSpreadTile - 1) / kSpreadTile;
  std::vector<TileSum> tiles(std::size_t{columns} * rows);
  parallel_for(rows, 1, [&](std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t y = begin * kSpreadTile; y < std::min<std::uint64_t>(end * kSpreadTile, test.height); ++y) {
      TileSum* row = &tiles[y / kSpreadTile * columns];
      for (std::uint32_t x = 0; x < test.width; ++x)
        add_pixel(test, reference, y * test.width + x, row[x / kSpreadTile]);
    }
  });
  TileSum all;
  for (const TileSum& tile : tiles) {
    all.squares += tile.squares;
    all.pixels += tile.pixels;
  }
  ScoreSpread spread{.pixels = all.pixels, .mean_square = all.mean()};
  // Half the false alarms for the whole, half for its parts.
  if (all.below_chance(0.5 * kSpreadFalseAlarm)) {
    spread.too_small = true;
    spread.width = test.width;
    spread.height = test.height;
    spread.mean_square_there = spread.mean_square;
    return spread;
  }
  const double level = 0.5 * kSpreadFalseAlarm / static_cast<double>(tiles.size());
  const auto found = std::ranges::find_if(tiles, [&](const TileSum& tile) { return tile.below_chance(level); });
  if (found == tiles.end()) return spread;
  const auto index = static_cast<std::uint32_t>(found - tiles.begin());
  spread.too_small = true;
  spread.x = index % columns * kSpreadTile;
  spread.y = index / columns * kSpreadTile;
  spread.width = std::min(kSpreadTile, test.width - spread.x);
  spread.height = std::min(kSpreadTile, test.height - spread.y);
  spread.mean_square_there = found->mean();
  return spread;
}

std::string spread_text(const ScoreSpread& spread) {
  const std::string where =
      spread.mean_square_there == spread.mean_square
          ? ""
          : fmt::format(" in the {}x{} pixels from ({}, {}) on", spread.width, spread.height, spread.x, spread.y);
  return fmt::format(
      "the differences are far smaller than the standard errors claim{}: their squares are {:.2g} of what is expected "
      "of "
      "independent pictures, which happens by chance less than once in {:.0e} comparisons; the errors are too large, "
      "or the "
      "pictures share their noise (render one with another --seed)",
      where, spread.mean_square_there, 1.0 / kSpreadFalseAlarm);
}

}  // namespace etendue
