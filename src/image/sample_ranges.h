#pragma once
/// Sets of sample indices, as films carry them: sorted, disjoint, non-empty half-open ranges with gaps between them.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace etendue {

using SampleRanges = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// "0:64,128:192"; empty for no ranges.
std::string to_text(const SampleRanges& ranges);
/// The inverse of to_text; nothing if the text is not exactly what to_text writes.
std::optional<SampleRanges> parse_sample_ranges(std::string_view text);

/// True when the ranges are non-empty, sorted and separated by gaps.
bool is_canonical(const SampleRanges& ranges);
/// Sorts the ranges and joins adjacent ones. They must be disjoint.
SampleRanges canonical(SampleRanges ranges);
/// How many indices the ranges hold.
std::uint64_t sample_count(const SampleRanges& ranges);
/// The smallest index; 2^32 - 1, which is not a valid index, if there are no samples.
std::uint32_t lowest_sample(const SampleRanges& ranges);

}  // namespace etendue
