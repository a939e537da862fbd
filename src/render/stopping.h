#pragma once
/// When a render is good enough to stop: optional stopping by the standard error.

#include <cstdint>

#include "image/film.h"

namespace etendue {

/// Root mean square of the standard error over pixels and channels, divided by the mean pixel value of the film: the
/// noise as a fraction of the image's brightness. Infinite for a film without light, of which nothing is known yet, and
/// while a pixel has fewer than two samples.
double relative_standard_error(const Film& film);

/// How bright, as a multiple of the mean of the picture, light may be that no sample has met yet.
inline constexpr double kUnseenBrightness = 100.0;
/// What a render is stopped by: relative_standard_error, and with it, in the root of the squares, what the samples
/// cannot know. Light that none of N pixels with n samples each has met comes with at most 3 in N · n samples
/// (confidence 0.95) [Hanley1983]; if it is kUnseenBrightness times as bright as the picture, its share of the error is
/// kUnseenBrightness · √(3/N) / n. So a start that shows no light, the same light in all samples, or light from a part
/// of the scene only does not pass for a finished picture, while a picture whose noise is all seen pays next to
/// nothing: that share falls with n, the noise with √n.
double stopping_error(const Film& film);

/// Sample counts at which the error is looked at: 16, 24, 32, 48, 64, 96, … They are fixed, so that where a render
/// stops depends on its samples only, not on time, devices or interruptions; and early looks, where the error is itself
/// uncertain, are few. Where a sample is the mean over a set of paths, `first` may be as low as 4: the error of a whole
/// picture is known well enough then. Returns the first one > `count`.
inline constexpr std::uint64_t kFirstErrorCheck = 16;
std::uint64_t next_error_check(std::uint64_t count, std::uint64_t first = kFirstErrorCheck);
bool is_error_check(std::uint64_t count, std::uint64_t first = kFirstErrorCheck);
/// `first` for a sampler with sets of so many paths: 16 paths or 4 sets, whatever is more; a power of two.
std::uint64_t first_error_check(std::uint32_t set_size);

}  // namespace etendue
