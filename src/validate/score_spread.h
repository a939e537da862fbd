#pragma once
/// Are the standard errors of two pictures to be believed? Errors that are too large hide every difference: the test
/// that passes says nothing then. But pictures that agree much better than independent ones can do by chance give them
/// away.

#include <cstdint>
#include <string>

#include "image/image.h"

namespace etendue {

/// Probability that independent pictures with errors of the right size, or up to √2 times too large, are told to be
/// none.
inline constexpr double kSpreadFalseAlarm = 1e-9;
/// Side of the squares that are looked at one by one, besides the whole: errors may be too large in a part.
inline constexpr std::uint32_t kSpreadTile = 32;

struct ScoreSpread {
  std::uint64_t pixels = 0;  ///< with at least two samples in both pictures and a score not decided by rounding
  double mean_square = 0;    ///< of their scores: about 1 for independent pictures with honest errors
  bool too_small = false;    ///< beyond what chance does at kSpreadFalseAlarm, somewhere
  /// Where: the first tile, or the whole picture.
  std::uint32_t x = 0, y = 0, width = 0, height = 0;
  double mean_square_there = 0;
};

/// The scores are those of test_images, pixel by pixel. Among samples that may be exchanged between the pictures the
/// square of a score has expectation 1 whatever their distribution, because its variance is that around the common
/// mean, and a second moment of at most 3, that of a normal score. Half the expectation is allowed for, for pictures
/// made by different estimators, and the probability comes from mean_lower_tail_bound.
ScoreSpread score_spread(const Image& test, const Image& reference);

/// One sentence without a full stop for a spread that is too small.
std::string spread_text(const ScoreSpread& spread);

}  // namespace etendue
