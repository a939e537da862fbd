#pragma once
/// When a render is good enough to stop: optional stopping by the standard error.

#include <cstdint>

#include "image/film.h"

namespace etendue {

/// Root mean square of the standard error over pixels and channels, divided by the mean pixel value of the film: the
/// noise as a fraction of the image's brightness. Infinite for a film without light, about which nothing is known yet,
/// and while a pixel has fewer than two samples.
double relative_standard_error(const Film& film);

/// Assumed brightness, relative to the picture's mean, of light that no sample has met yet.
inline constexpr double kUnseenBrightness = 100.0;
/// The stopping criterion: relative_standard_error and, added in quadrature, an allowance for what the samples cannot
/// know. Light that none of N pixels with n samples each has met has a frequency of at most 3 in N · n samples
/// (confidence 0.95) [Hanley1983]; if it is kUnseenBrightness times as bright as the picture, its share of the error is
/// kUnseenBrightness · √(3/N) / n. So a start that shows no light, the same light in all samples, or light from only a
/// part of the scene does not count as a finished picture, while a picture with fully sampled noise pays almost
/// nothing: that share falls with n, the noise with √n.
double stopping_error(const Film& film);

/// Sample counts at which the error is tested: 16, 24, 32, 48, 64, 96, … They are fixed, so that the stopping point
/// depends only on the samples, not on time, devices or interruptions; and early tests, when the error is itself
/// uncertain, are few. If a sample is the mean over a set of paths, `first` may be as low as 4: the error of a whole
/// picture is known well enough then. Returns the first one > `count`.
inline constexpr std::uint64_t kFirstErrorCheck = 16;
std::uint64_t next_error_check(std::uint64_t count, std::uint64_t first = kFirstErrorCheck);
bool is_error_check(std::uint64_t count, std::uint64_t first = kFirstErrorCheck);
/// `first` for a sampler with sets of this many paths: 16 paths or 4 sets, whichever is more; a power of two.
std::uint64_t first_error_check(std::uint32_t set_size);

}  // namespace etendue
