#include "validate/sample_comparison.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "core/errors.h"
#include "image/vectors.h"

namespace etendue {
namespace {

constexpr std::size_t kLocatedEach = 32;
constexpr std::size_t kWorstPixels = 8;
/// Samples darker than this share of the mean are measured against it: their relative error cannot be seen.
constexpr double kDarkShare = 1e-3;
/// Difference of accumulated radiance that counts as a parting of ways rather than rounding.
constexpr double kPartingError = 1e-3;

double largest(const glm::vec3& v) {
  return std::max(
      {std::abs(static_cast<double>(v.x)), std::abs(static_cast<double>(v.y)), std::abs(static_cast<double>(v.z))});
}

bool is_number(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Largest difference of a component relative to the larger of both samples, and at least to `floor`.
double relative_error(const glm::vec3& a, const glm::vec3& b, double floor) {
  const double difference = largest(a - b);
  if (difference == 0.0) return 0.0;
  return difference / std::max({largest(a), largest(b), floor});
}

std::vector<SampleId> choose_samples(std::uint64_t pixels, std::uint64_t budget) {
  constexpr std::uint64_t kPerPixel = 4;  // where not every pixel can be looked at
  std::vector<SampleId> ids;
  if (budget >= pixels) {
    const auto spp = static_cast<std::uint32_t>(std::min<std::uint64_t>(budget / pixels, 1u << 20));
    for (std::uint64_t p = 0; p < pixels; ++p) {
      for (std::uint32_t s = 0; s < spp; ++s) ids.push_back({static_cast<std::uint32_t>(p), s});
    }
    return ids;
  }
  // Multiples of the golden ratio spread evenly over the rows whatever the width is.
  constexpr double kGolden = 0.6180339887498949;
  for (std::uint64_t i = 0; i < std::max<std::uint64_t>(1, budget / kPerPixel); ++i) {
    const double fraction = std::fmod(0.5 + static_cast<double>(i) * kGolden, 1.0);
    const auto pixel = static_cast<std::uint32_t>(fraction * static_cast<double>(pixels));
    for (std::uint32_t s = 0; s < kPerPixel; ++s) ids.push_back({pixel, s});
  }
  return ids;
}

bool equal_bits(const SampleRecord& a, const SampleRecord& b) {
  using Bits = std::array<std::uint32_t, 3>;
  return a.signature == b.signature && std::bit_cast<Bits>(a.radiance) == std::bit_cast<Bits>(b.radiance);
}

struct RankedSample {
  double error = 0;
  SampleId id;
};

std::string vertex_number(std::uint32_t value) {
  return value == PathVertex::kNone ? "none" : fmt::format("{}", value);
}
std::string vector_text(const glm::vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", v.x, v.y, v.z);
}

/// Median, 99.9 % quantile and maximum.
void fill_quantiles(std::vector<double>& errors, SampleComparison& out) {
  if (errors.empty()) return;
  const auto at = [&](double q) {
    const auto nth = errors.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(errors.size() - 1));
    std::nth_element(errors.begin(), nth, errors.end());
    return *nth;
  };
  out.median_error = at(0.5);
  out.p999_error = at(0.999);
  out.max_error = at(1.0);
}

std::vector<WorstPixel> worst_pixels(const std::map<std::uint32_t, WorstPixel>& pixels) {
  std::vector<WorstPixel> out;
  out.reserve(pixels.size());
  for (const auto& [pixel, entry] : pixels) out.push_back(entry);
  const std::size_t count = std::min(kWorstPixels, out.size());
  std::partial_sort(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count), out.end(),
                    [](const WorstPixel& a, const WorstPixel& b) {
                      return a.largest_error != b.largest_error ? a.largest_error > b.largest_error : a.flips > b.flips;
                    });
  out.resize(count);
  return out;
}

/// The worst sample, more of those that are off, and some flips, each retraced.
void locate(Renderer& device, Renderer& reference, std::vector<RankedSample>& off, const RankedSample& worst,
            const std::vector<SampleId>& flips, SampleComparison& out) {
  std::sort(off.begin(), off.end(), [](const RankedSample& a, const RankedSample& b) { return a.error > b.error; });
  std::vector<RankedSample> chosen;
  if (off.empty() && worst.error > 0.0) chosen.push_back(worst);
  std::copy_n(off.begin(), std::min(kLocatedEach, off.size()), std::back_inserter(chosen));
  const std::size_t stride = std::max<std::size_t>(1, flips.size() / kLocatedEach);
  for (std::size_t i = 0; i < flips.size() && i < stride * kLocatedEach; i += stride) chosen.push_back({0.0, flips[i]});
  for (const RankedSample& sample : chosen) {
    Divergence d = locate_divergence(device, reference, sample.id);
    if (sample.error > 0.0) d.relative_error = sample.error;
    if (!d.what.empty()) ++out.first_differences[fmt::format("bounce {}: {}", d.bounce, d.what)];
    out.located.push_back(std::move(d));
  }
}

}  // namespace

bool SampleComparison::rounding_only() const {
  return samples > 0 && same_mean() && median_error <= limits.median_error &&
         off_per_million() <= limits.off_per_million && flips_per_million() <= limits.flips_per_million;
}

TracedSamples trace_some(Renderer& renderer, std::uint32_t width, std::uint32_t height, std::uint64_t budget) {
  TracedSamples traced{.ids = choose_samples(std::uint64_t{width} * height, budget), .records = {}};
  traced.records = renderer.trace_samples(traced.ids);
  return traced;
}

SampleComparison compare_samples(Renderer& device, const TracedSamples& by_device, Renderer& reference,
                                 const TracedSamples& by_reference, const SampleLimits& limits) {
  const std::vector<SampleId>& ids = by_device.ids;
  const std::vector<SampleRecord>&a = by_device.records, &b = by_reference.records;
  SampleComparison out;
  out.limits = limits;
  out.samples = ids.size();

  RunningMoments mean_a, mean_b, differences;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!is_number(a[i].radiance) || !is_number(b[i].radiance)) {
      ++out.non_finite;
      continue;
    }
    const double ya = luminance(a[i].radiance), yb = luminance(b[i].radiance);
    mean_a.add(ya);
    mean_b.add(yb);
    differences.add(ya - yb);
  }
  if (differences.n() >= 2) out.paired = t_test(mean_a.mean(), differences.variance(), differences.n(), mean_b.mean());
  const double floor = kDarkShare * std::max(std::abs(mean_a.mean()), std::abs(mean_b.mean()));

  std::vector<double> errors;
  std::vector<RankedSample> off;
  std::vector<SampleId> flips;
  RankedSample worst;
  std::map<std::uint32_t, WorstPixel> pixels;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (equal_bits(a[i], b[i])) {
      ++out.equal_bits;
      errors.push_back(0.0);
      continue;
    }
    WorstPixel& pixel = pixels.try_emplace(ids[i].pixel, WorstPixel{ids[i].pixel, 0, 0.0}).first->second;
    if (a[i].signature != b[i].signature) {
      ++out.flips;
      ++pixel.flips;
      flips.push_back(ids[i]);
      continue;
    }
    if (!is_number(a[i].radiance) || !is_number(b[i].radiance)) {
      ++out.off;
      off.push_back({1e300, ids[i]});  // worse than any number
      continue;
    }
    const double error = relative_error(a[i].radiance, b[i].radiance, floor);
    errors.push_back(error);
    pixel.largest_error = std::max(pixel.largest_error, error);
    if (error > worst.error) worst = {error, ids[i]};
    out.off += error > limits.off_error;
    if (error > kPartingError) off.push_back({error, ids[i]});
  }
  fill_quantiles(errors, out);
  out.worst = worst_pixels(pixels);
  locate(device, reference, off, worst, flips, out);
  return out;
}

SampleComparison compare_samples(Renderer& device, Renderer& reference, std::uint32_t width, std::uint32_t height,
                                 std::uint64_t budget, const SampleLimits& limits) {
  return compare_samples(device, trace_some(device, width, height, budget), reference,
                         trace_some(reference, width, height, budget), limits);
}

Divergence locate_divergence(Renderer& device, Renderer& reference, SampleId id) {
  const std::vector<PathVertex> a = device.trace_path(id), b = reference.trace_path(id);
  Divergence d;
  d.id = id;
  if (!a.empty()) d.device_radiance = a.back().radiance;
  if (!b.empty()) d.reference_radiance = b.back().radiance;
  d.relative_error = relative_error(d.device_radiance, d.reference_radiance, 0.0);

  struct Field {
    const char* name;
    std::uint32_t PathVertex::*value;
  };
  static constexpr std::array<Field, 7> kFields{{{"instance", &PathVertex::instance},
                                                 {"primitive", &PathVertex::primitive},
                                                 {"light instance", &PathVertex::light_instance},
                                                 {"light primitive", &PathVertex::light_primitive},
                                                 {"light contribution", &PathVertex::light_contributed},
                                                 {"lobe", &PathVertex::lobe},
                                                 {"roulette", &PathVertex::survived}}};
  const auto part = [&](std::size_t bounce, const char* what, std::string va, std::string vb) {
    d.bounce = static_cast<std::uint32_t>(bounce);
    d.what = what;
    d.device = std::move(va);
    d.reference = std::move(vb);
  };
  // The radiance is what the vertex adds up to, so that it is compared after the light and before the next direction.
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    for (const Field& f : kFields) {
      const std::uint32_t va = a[i].*f.value, vb = b[i].*f.value;
      if (va == vb) continue;
      part(i, f.name, vertex_number(va), vertex_number(vb));
      return d;
    }
    // NaN must not compare as agreement.
    if (!(relative_error(a[i].radiance, b[i].radiance, 0.0) <= kPartingError)) {
      part(i, "radiance", vector_text(a[i].radiance), vector_text(b[i].radiance));
      return d;
    }
  }
  if (a.size() != b.size()) {
    part(std::min(a.size(), b.size()), "path length", fmt::format("{}", a.size()), fmt::format("{}", b.size()));
  }
  return d;
}

}  // namespace etendue
