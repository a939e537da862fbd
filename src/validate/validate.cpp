#include "validate/validate.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"

namespace etendue {
namespace {

constexpr const char* kReferenceLabel = "reference";

/// A renderer and what it has made of the scene.
struct Side {
  std::string label;
  std::unique_ptr<Renderer> renderer;
  TracedSamples samples;         // of L2
  std::uint32_t image_seed = 0;  // what follows is of L3
  Image image;
  std::uint64_t rejected = 0;
  std::vector<RejectedSample> located;
};

Side open_side(const LabelledFactory& entrant, const SharedScene& shared, const ValidateOptions& options) {
  const Camera& camera = shared.scene().camera;
  Side side{.label = entrant.label, .renderer = entrant.make(shared, {options.seed, FilmQuantity::color})};
  side.samples = trace_some(*side.renderer, camera.width, camera.height, options.sample_budget);
  return side;
}

void render_image(Side& side, const Scene& scene, std::uint32_t spp, const ValidateOptions& options) {
  side.renderer->set_view(view_of(scene), {side.image_seed, FilmQuantity::color});
  Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
  const auto sets = static_cast<std::uint32_t>(scene.sampler.sets_of(spp));
  if (side.renderer->render({0, sets}, film, options.progress, side.located) != sets) {
    throw Error(ErrorKind::interrupted,
                fmt::format("{}: stopped before all {} samples were done; there is no verdict", scene.file, spp));
  }
  side.rejected = film.rejected();
  side.image = image_from_film(film, {{"scene", scene.name},
                                      {"device", side.renderer->device_name()},
                                      {"driver", side.renderer->driver_name()},
                                      {"seed", fmt::format("{}", side.image_seed)},
                                      {"samples", fmt::format("{}", spp)}});
}

Verdict judge(const Validation& v) {
  if (v.device_rejected + v.reference_rejected > 0) return Verdict::different;
  const bool paired = v.samples.paired.n >= 2 || v.samples.non_finite > 0;
  if (!v.tests.passed() || (paired && !v.samples.same_mean())) return Verdict::different;
  if (!paired || !v.tests.made()) return Verdict::untested;
  if (v.samples.identical()) return Verdict::identical;
  return v.samples.rounding_only() ? Verdict::rounding_only : Verdict::statistically_equal;
}

// Whole sets, and two of them at least: an image needs standard errors to be tested.
std::uint32_t samples_of_images(const Scene& scene, const ValidateOptions& options) {
  const std::uint32_t wanted =
      options.samples_per_pixel != 0 ? options.samples_per_pixel : std::clamp(scene.sampler.sample_count, 16u, 64u);
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(scene.sampler.sets_of(wanted), 2)
                                    << scene.sampler.set_bits);
}

struct PairOfSides {
  Side *device, *reference;
};

// Each device against the reference, which is the last side, and then against those before it.
std::vector<PairOfSides> all_pairs(std::vector<Side>& sides) {
  std::vector<PairOfSides> pairs;
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) pairs.push_back({&sides[i], &sides.back()});
  for (std::size_t i = 1; i + 1 < sides.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) pairs.push_back({&sides[i], &sides[j]});
  }
  return pairs;
}

SampleComparison compare_pair(const PairOfSides& pair, const SampleLimits& limits) {
  return compare_samples(*pair.device->renderer, pair.device->samples, *pair.reference->renderer,
                         pair.reference->samples, limits);
}

// Two devices may be apart by the sum of what each may be from the reference.
SampleLimits sum_of_limits(const SampleLimits& a, const SampleLimits& b) {
  SampleLimits sum = a;
  sum.median_error += b.median_error;
  sum.off_per_million += b.off_per_million;
  sum.flips_per_million += b.flips_per_million;
  return sum;
}

// In a scene of small parts in a wide space, or of glass and mirrors that curve, rounding parts more paths than in
// others. How many is measured on the reference itself: the rounding of a device is of the same size, not of the same
// kind, hence half as much again.
void raise_limits(SampleLimits& limits, const SampleComparison& rounding) {
  constexpr double kRoom = 1.5;
  limits.flips_per_million = std::max(limits.flips_per_million, kRoom * rounding.flips_per_million());
  limits.off_per_million = std::max(limits.off_per_million, kRoom * rounding.off_per_million());
}

// L2 of all pairs.
void compare_samples_of(const std::vector<PairOfSides>& pairs, const SharedScene& shared,
                        const ValidateOptions& options, std::vector<Validation>& out) {
  SampleLimits base = options.limits;
  base.paired_level = sidak_level(base.paired_level, pairs.size());
  std::optional<SampleComparison> rounding;
  std::map<const Side*, SampleLimits> limits;
  for (const PairOfSides& pair : pairs) {
    Validation v;
    if (pair.reference->label == kReferenceLabel) {
      v.samples = compare_pair(pair, base);
      if (options.make_shaken && !v.samples.rounding_only()) {
        if (!rounding) {
          PairOfSides shaken = pair;
          Side shaken_reference = open_side({"shaken", options.make_shaken}, shared, options);
          shaken.device = &shaken_reference;
          rounding = compare_pair(shaken, options.limits);
        }
        v.rounding = rounding;
        raise_limits(v.samples.limits, *rounding);
      }
      limits[pair.device] = v.samples.limits;
    } else {
      v.samples = compare_pair(pair, sum_of_limits(limits.at(pair.device), limits.at(pair.reference)));
    }
    out.push_back(std::move(v));
  }
}

// L3 of a pair, and what becomes of both.
void compare_images_of(const PairOfSides& pair, double significance, const ValidateOptions& options, Validation& v) {
  const Side &device = *pair.device, &reference = *pair.reference;
  v.device_label = device.label;
  v.reference_label = reference.label;
  v.device = device.renderer->device_name();
  v.device_driver = device.renderer->driver_name();
  v.reference = reference.renderer->device_name();
  v.reference_driver = reference.renderer->driver_name();
  v.device_seed = device.image_seed;
  v.reference_seed = reference.image_seed;
  v.device_image = device.image;
  v.reference_image = reference.image;
  v.device_rejected = device.rejected;
  v.reference_rejected = reference.rejected;
  v.rejected = device.located;
  v.rejected.insert(v.rejected.end(), reference.located.begin(), reference.located.end());
  v.tests = test_images(v.device_image, v.reference_image, significance);
  v.verdict = judge(v);
  v.worst_accepted = options.worst_accepted;
  v.allow_untested = options.allow_untested;
  if (v.verdict == Verdict::untested)
    v.untested_why =
        v.tests.made() ? "fewer than two samples were compared one by one; raise --samples" : v.tests.gap();
}

std::string pixel_text(std::uint32_t pixel, std::uint32_t width) {
  return fmt::format("({}, {})", pixel % width, pixel / width);
}

// "the device", or "device 1" where there are several.
std::string side_name(const std::string& label) {
  return label == kReferenceLabel || label == kOnlyDeviceLabel ? "the " + label : "device " + label;
}

std::string divergence_text(const Divergence& d, const Validation& v) {
  const std::uint32_t width = v.device_image.width;
  const std::string where = fmt::format("pixel {}, sample {}", pixel_text(d.id.pixel, width), d.id.sample);
  if (d.what.empty())
    return fmt::format("{}: relative error {:.3g}, no single bounce diverges by more than rounding", where,
                       d.relative_error);
  return fmt::format("{}, bounce {}: {} is {} on {} and {} on {}", where, d.bounce, d.what, d.device,
                     side_name(v.device_label), d.reference, side_name(v.reference_label));
}

std::string samples_text(const Validation& v) {
  const SampleComparison& s = v.samples;
  std::string out = fmt::format(
      "L2, equal random numbers: {} samples, {} equal to the bit, {:.1f} branch flips per million (limit {:g})\n",
      s.samples, s.equal_bits, s.flips_per_million(), s.limits.flips_per_million);
  out += fmt::format(
      "  relative error without a flip: median {:.3g} (limit {:g}), 99.9 % {:.3g}, maximum {:.3g}; "
      "{:.1f} per million beyond {:g} (limit {:g})\n",
      s.median_error, s.limits.median_error, s.p999_error, s.max_error, s.off_per_million(), s.limits.off_error,
      s.limits.off_per_million);
  out += fmt::format("  means {:.8g} and {:.8g}: paired t = {:.4g}, p = {:.3g} (false-alarm rate {:g})\n",
                     s.paired.mean, s.paired.reference, s.paired.t, s.paired.p_value, s.limits.paired_level);
  if (s.non_finite > 0) out += fmt::format("  {} samples are NaN or infinite\n", s.non_finite);
  for (const WorstPixel& p : s.worst) {
    out += fmt::format("  pixel {}: largest error {:.3g}, {} flip(s)\n", pixel_text(p.pixel, v.device_image.width),
                       p.largest_error, p.flips);
  }
  if (!s.located.empty()) out += "  " + divergence_text(s.located.front(), v) + "\n";
  for (const auto& [what, count] : s.first_differences) {
    out += fmt::format("  {} of {} retraced samples diverge at {}\n", count, s.located.size(), what);
  }
  return out;
}

std::string verdict_text(const Validation& v) {
  return fmt::format("verdict: {}{}", verdict_name(v.verdict), v.untested_why.empty() ? "" : ": " + v.untested_why);
}

}  // namespace

Validation validate_scene(const Scene& scene, const RendererFactory& make_device, const RendererFactory& make_reference,
                          const ValidateOptions& options) {
  return std::move(validate_devices(scene, {{kOnlyDeviceLabel, make_device}}, make_reference, options).pairs.front());
}

DevicesValidation validate_devices(const Scene& scene, const std::vector<LabelledFactory>& devices,
                                   const RendererFactory& make_reference, const ValidateOptions& options) {
  const SharedScene shared(scene);
  std::vector<Side> sides;
  for (const LabelledFactory& device : devices) sides.push_back(open_side(device, shared, options));
  sides.push_back(open_side({kReferenceLabel, make_reference}, shared, options));

  DevicesValidation all;
  all.scene = scene.file.empty() ? scene.name : scene.file;
  all.seed = options.seed;
  all.samples_per_pixel = samples_of_images(scene, options);
  all.samples = sides.front().samples.ids.size();
  all.significance = options.significance;
  for (const Side& s : sides) all.entrants.push_back({s.label, s.renderer->device_name(), s.renderer->driver_name()});

  // Samples first, then pictures: what retraces some of the samples needs their seed.
  const std::vector<PairOfSides> pairs = all_pairs(sides);
  compare_samples_of(pairs, shared, options, all.pairs);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool first = i == 0, reference = i + 1 == sides.size();
    sides[i].image_seed = options.seed + (first ? 1 : reference ? 2 : static_cast<std::uint32_t>(i) + 2);
    render_image(sides[i], scene, all.samples_per_pixel, options);
  }
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Validation& v = all.pairs[i];
    v.scene = all.scene;
    v.seed = all.seed;
    v.samples_per_pixel = all.samples_per_pixel;
    compare_images_of(pairs[i], sidak_level(options.significance, pairs.size()), options, v);
  }
  return all;
}

Verdict DevicesValidation::verdict() const {
  Verdict worst = Verdict::identical;
  // Untested is the last of its kind, but a difference that was found says more than a test that could not be made.
  for (const Validation& pair : pairs) {
    if (worst != Verdict::different)
      worst = pair.verdict == Verdict::different ? pair.verdict : std::max(worst, pair.verdict);
  }
  return worst;
}

bool DevicesValidation::passed() const {
  return std::ranges::all_of(pairs, &Validation::passed);
}

std::string devices_text(const DevicesValidation& all) {
  std::string out = fmt::format("{}: every pair of {} devices and the reference\n",
                                text::printable(all.scene, text::kLongestLine), all.entrants.size() - 1);
  for (const auto& entrant : all.entrants)
    out += fmt::format("{:>9}  {} ({})\n", entrant.label, entrant.device, entrant.driver);
  out += fmt::format("{:<23} {:>9} {:>7} {:>7} {:>9} {:>8} {:>9} {:>8} {:>8}  verdict\n", "pair", "equal bits", "flips",
                     "off", "median", "paired p", "pixels p", "blocks p", "mean p");
  for (const Validation& v : all.pairs) {
    out += fmt::format("{:<23} {:>8.2f} % {:>7.0f} {:>7.0f} {:>9.2g} {:>8.2g}",
                       fmt::format("{} against {}", v.device_label, v.reference_label),
                       v.samples.samples == 0
                           ? 0.0
                           : 100.0 * static_cast<double>(v.samples.equal_bits) / static_cast<double>(v.samples.samples),
                       v.samples.flips_per_million(), v.samples.off_per_million(), v.samples.median_error,
                       v.samples.paired.p_value);
    for (std::size_t i = 0; i < v.tests.families.size(); ++i) {
      const TestFamily& family = v.tests.families[i];
      out +=
          fmt::format(" {:>{}}", family.tests == 0 ? "none" : fmt::format("{:.2g}", family.family_p), i == 0 ? 9 : 8);
    }
    out += fmt::format("  {}{}\n", verdict_name(v.verdict), v.passed() ? "" : "  FAILED");
  }
  out += fmt::format(
      "flips and off: of a million samples; {} samples with equal random numbers, then {} samples per pixel with "
      "others; "
      "false-alarm rate {:g} for all pictures together (Šidák)\n",
      all.samples, all.samples_per_pixel, all.significance);
  for (const Validation& v : all.pairs) {
    if (!v.passed()) out += "\n" + validation_text(v);
  }
  return out + fmt::format("verdict of all pairs: {}\n", verdict_name(all.verdict()));
}

Json devices_json(const DevicesValidation& all) {
  Json entrants = Json::array(), pairs = Json::array();
  for (const auto& e : all.entrants)
    entrants.push_back({{"label", e.label}, {"device", e.device}, {"driver", e.driver}});
  for (const Validation& v : all.pairs) {
    Json pair = validation_json(v);
    pair["labels"] = {v.device_label, v.reference_label};
    pairs.push_back(std::move(pair));
  }
  return {{"scene", all.scene},    {"seed", all.seed}, {"significance", all.significance},
          {"devices", entrants},   {"pairs", pairs},   {"verdict", verdict_name(all.verdict())},
          {"passed", all.passed()}};
}

std::string validation_text(const Validation& v) {
  const std::uint32_t width = v.device_image.width;
  std::string out = fmt::format("{}: {} ({}) against {} ({})\n", text::printable(v.scene, text::kLongestLine), v.device,
                                v.device_driver, v.reference, v.reference_driver);
  out += samples_text(v);
  if (v.rounding) {
    out += fmt::format(
        "  the reference, perturbed by rounding alone: {:.1f} flips and {:.1f} off per million; limits are 1.5 times "
        "as much\n",
        v.rounding->flips_per_million(), v.rounding->off_per_million());
  }
  out += fmt::format("L3, independent random numbers: {} samples per pixel, seeds {} and {}\n", v.samples_per_pixel,
                     v.device_seed, v.reference_seed);
  out += image_tests_text(v.tests);
  if (v.device_rejected + v.reference_rejected > 0) {
    out += fmt::format("rejected samples (NaN, infinite or out of range): {} on {}, {} on {}", v.device_rejected,
                       side_name(v.device_label), v.reference_rejected, side_name(v.reference_label));
    if (!v.rejected.empty()) {
      const RejectedSample& r = v.rejected.front();
      out += fmt::format("; first: pixel {}, sample {}, segment {}", pixel_text(r.id.pixel, width), r.id.sample,
                         r.segments);
    }
    out += "\n";
  }
  return out + verdict_text(v) + "\n";
}

Json validation_json(const Validation& v) {
  const SampleComparison& s = v.samples;
  const std::uint32_t width = v.device_image.width;
  Json worst = Json::array(), located = Json::array(), rejected = Json::array();
  for (const WorstPixel& p : s.worst) {
    worst.push_back(
        {{"x", p.pixel % width}, {"y", p.pixel / width}, {"flips", p.flips}, {"largestError", p.largest_error}});
  }
  for (const Divergence& d : s.located) {
    located.push_back({{"x", d.id.pixel % width},
                       {"y", d.id.pixel / width},
                       {"sample", d.id.sample},
                       {"bounce", d.bounce},
                       {"what", d.what},
                       {"device", d.device},
                       {"reference", d.reference},
                       {"relativeError", d.relative_error}});
  }
  for (const RejectedSample& r : v.rejected) {
    rejected.push_back(
        {{"x", r.id.pixel % width}, {"y", r.id.pixel / width}, {"sample", r.id.sample}, {"segment", r.segments}});
  }
  return {{"scene", v.scene},
          {"device", v.device},
          {"driver", v.device_driver},
          {"reference", v.reference},
          {"seed", v.seed},
          {"samplesPerPixel", v.samples_per_pixel},
          {"L2",
           {{"samples", s.samples},
            {"equalToTheBit", s.equal_bits},
            {"flipsPerMillion", s.flips_per_million()},
            {"medianError", s.median_error},
            {"p999Error", s.p999_error},
            {"maxError", s.max_error},
            {"offPerMillion", s.off_per_million()},
            {"nonFinite", s.non_finite},
            {"pairedP", s.paired.p_value},
            {"pairedT", s.paired.t},
            {"deviceMean", s.paired.mean},
            {"referenceMean", s.paired.reference},
            {"firstDifferences", s.first_differences},
            {"shakenReference", v.rounding ? Json({{"flipsPerMillion", v.rounding->flips_per_million()},
                                                   {"offPerMillion", v.rounding->off_per_million()}})
                                           : Json(nullptr)},
            {"limits",
             {{"median", s.limits.median_error},
              {"off", s.limits.off_error},
              {"offPerMillion", s.limits.off_per_million},
              {"flipsPerMillion", s.limits.flips_per_million},
              {"pairedLevel", s.limits.paired_level}}},
            {"worstPixels", worst},
            {"located", located}}},
          {"L3", image_tests_json(v.tests)},
          {"rejected", {{"device", v.device_rejected}, {"reference", v.reference_rejected}, {"located", rejected}}},
          {"verdict", verdict_name(v.verdict)},
          {"untestedWhy", v.untested_why},
          {"passed", v.passed()}};
}

JunitCase validation_junit(const Validation& v) {
  JunitCase junit;
  junit.name = v.scene + " on " + v.device;
  if (v.reference_label != kReferenceLabel) junit.name += " against " + v.reference;
  junit.failed = !v.passed();
  junit.skipped = v.passed() && v.verdict == Verdict::untested;
  junit.message = verdict_text(v);
  junit.details = validation_text(v);
  return junit;
}

}  // namespace etendue
