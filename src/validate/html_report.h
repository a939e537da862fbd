#pragma once
/// The HTML report of `compare` and `validate`: one file with everything in it, for any browser, without network or
/// server.

#include <cstdint>
#include <string>

#include "validate/compare.h"
#include "validate/validate.h"

namespace etendue {

/// Largest number of pixels whose values a report holds: a file of 30 MB at most, which a browser still shows at once.
inline constexpr std::uint64_t kReportPixels = 600000;

/// Report of two pictures. Their float32 values travel in the file bit by bit; those of pictures of more than
/// kReportPixels as means of squares of pixels, with the worst score of each. Texts from the files are cut to a line.
std::string comparison_html(const Comparison& comparison, const Image& test, const Image& reference);
/// The same of the L3 pictures of a validation, with what L2 found. `metrics` as for compare_images.
std::string validation_html(const Validation& validation, const MetricOptions& metrics = {});

/// Standard base64 with padding [RFC 4648].
std::string base64(const void* bytes, std::size_t size);
/// JSON that may stand inside <script>: '<' is written as an escape; invalid UTF-8 becomes U+FFFD.
std::string script_json(const Json& json);

}  // namespace etendue
