#include "validate/validate.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"

namespace etendue {
namespace {

Image render_image(Renderer& renderer, const Scene& scene, std::uint32_t spp, const ValidateOptions& options,
                   std::uint32_t seed, std::uint64_t& rejected, std::vector<RejectedSample>& located) {
  Film film(scene.camera.width, scene.camera.height, film_exponent(scene));
  std::vector<RejectedSample> here;
  const auto sets = static_cast<std::uint32_t>(scene.sampler.sets_of(spp));
  if (renderer.render({0, sets}, film, options.progress, here) != sets) {
    throw Error(ErrorKind::interrupted,
                fmt::format("{}: stopped before all {} samples were done; there is no verdict", scene.file, spp));
  }
  rejected = film.rejected();
  located.insert(located.end(), here.begin(), here.end());
  return image_from_film(film, {{"scene", scene.name},
                                {"device", renderer.device_name()},
                                {"driver", renderer.driver_name()},
                                {"seed", fmt::format("{}", seed)},
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

// In a scene of small parts in a wide space, or of glass and mirrors that curve, rounding parts more paths than in
// others. How many is measured on the reference itself: the rounding of a device is of the same size, not of the same
// kind, hence half as much again.
void raise_limits(Validation& v, Renderer& reference, const Scene& scene, const ValidateOptions& options) {
  constexpr double kRoom = 1.5;
  const auto shaken = options.make_shaken(scene, {options.seed, FilmQuantity::color});
  v.rounding = compare_samples(*shaken, reference, scene.camera.width, scene.camera.height, options.sample_budget,
                               options.limits);
  SampleLimits& limits = v.samples.limits;
  limits.flips_per_million = std::max(limits.flips_per_million, kRoom * v.rounding->flips_per_million());
  limits.off_per_million = std::max(limits.off_per_million, kRoom * v.rounding->off_per_million());
}

std::string pixel_text(std::uint32_t pixel, std::uint32_t width) {
  return fmt::format("({}, {})", pixel % width, pixel / width);
}

std::string divergence_text(const Divergence& d, std::uint32_t width) {
  const std::string where = fmt::format("pixel {}, sample {}", pixel_text(d.id.pixel, width), d.id.sample);
  if (d.what.empty())
    return fmt::format("{}: relative error {:.3g}, no single bounce parts by more than rounding", where,
                       d.relative_error);
  return fmt::format("{}, bounce {}: {} is {} on the device and {} on the reference", where, d.bounce, d.what, d.device,
                     d.reference);
}

std::string samples_text(const SampleComparison& s, std::uint32_t width) {
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
    out += fmt::format("  pixel {}: largest error {:.3g}, {} flip(s)\n", pixel_text(p.pixel, width), p.largest_error,
                       p.flips);
  }
  if (!s.located.empty()) out += "  " + divergence_text(s.located.front(), width) + "\n";
  for (const auto& [what, count] : s.first_differences) {
    out += fmt::format("  {} of {} retraced samples part at {}\n", count, s.located.size(), what);
  }
  return out;
}

std::string verdict_text(const Validation& v) {
  return fmt::format("verdict: {}{}", verdict_name(v.verdict), v.untested_why.empty() ? "" : ": " + v.untested_why);
}

}  // namespace

Validation validate_scene(const Scene& scene, const RendererFactory& make_device, const RendererFactory& make_reference,
                          const ValidateOptions& options) {
  Validation v;
  v.scene = scene.file.empty() ? scene.name : scene.file;
  v.seed = options.seed;
  v.worst_accepted = options.worst_accepted;
  v.samples_per_pixel =
      options.samples_per_pixel != 0 ? options.samples_per_pixel : std::clamp(scene.sampler.sample_count, 16u, 64u);
  // Whole sets, and two of them at least: an image needs standard errors to be tested.
  v.samples_per_pixel = static_cast<std::uint32_t>(
      std::max<std::uint64_t>(scene.sampler.sets_of(v.samples_per_pixel), 2) << scene.sampler.set_bits);
  const auto device = make_device(scene, {options.seed, FilmQuantity::color});
  const auto reference = make_reference(scene, {options.seed, FilmQuantity::color});
  v.device = device->device_name();
  v.device_driver = device->driver_name();
  v.reference = reference->device_name();
  v.reference_driver = reference->driver_name();
  v.samples = compare_samples(*device, *reference, scene.camera.width, scene.camera.height, options.sample_budget,
                              options.limits);
  if (options.make_shaken && !v.samples.rounding_only()) raise_limits(v, *reference, scene, options);

  device->set_view(view_of(scene), {options.seed + 1, FilmQuantity::color});
  v.device_image =
      render_image(*device, scene, v.samples_per_pixel, options, options.seed + 1, v.device_rejected, v.rejected);
  reference->set_view(view_of(scene), {options.seed + 2, FilmQuantity::color});
  v.reference_image =
      render_image(*reference, scene, v.samples_per_pixel, options, options.seed + 2, v.reference_rejected, v.rejected);
  v.tests = test_images(v.device_image, v.reference_image, options.significance);
  v.verdict = judge(v);
  v.allow_untested = options.allow_untested;
  if (v.verdict == Verdict::untested)
    v.untested_why =
        v.tests.made() ? "fewer than two samples were compared one by one; raise --samples" : v.tests.gap();
  return v;
}

std::string validation_text(const Validation& v) {
  const std::uint32_t width = v.device_image.width;
  std::string out = fmt::format("{}: {} ({}) against {} ({})\n", text::printable(v.scene, text::kLongestLine), v.device,
                                v.device_driver, v.reference, v.reference_driver);
  out += samples_text(v.samples, width);
  if (v.rounding) {
    out += fmt::format(
        "  the reference, shaken by rounding alone: {:.1f} flips and {:.1f} off per million; limits are half as much "
        "again\n",
        v.rounding->flips_per_million(), v.rounding->off_per_million());
  }
  out += fmt::format("L3, independent random numbers: {} samples per pixel, seeds {} and {}\n", v.samples_per_pixel,
                     v.seed + 1, v.seed + 2);
  out += image_tests_text(v.tests);
  if (v.device_rejected + v.reference_rejected > 0) {
    out += fmt::format("rejected samples (NaN, infinite or out of range): {} on the device, {} on the reference",
                       v.device_rejected, v.reference_rejected);
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
  junit.failed = !v.passed();
  junit.skipped = v.passed() && v.verdict == Verdict::untested;
  junit.message = verdict_text(v);
  junit.details = validation_text(v);
  return junit;
}

}  // namespace etendue
