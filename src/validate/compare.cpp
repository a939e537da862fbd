#include "validate/compare.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"

namespace etendue {
namespace {

struct MetricRow {
  const char* name;
  bool upper;  ///< smaller is better
  double (*value)(const Metrics&);
};

// clang-format off
constexpr std::array<MetricRow, 11> kMetricRows{{
    {"mse", true, [](const Metrics& m) { return m.mse; }},
    {"rmse", true, [](const Metrics& m) { return m.rmse; }},
    {"relmse", true, [](const Metrics& m) { return m.rel_mse; }},
    {"mae", true, [](const Metrics& m) { return m.mae; }},
    {"flip", true, [](const Metrics& m) { return m.flip; }},
    {"hdrflip", true, [](const Metrics& m) { return m.hdr_flip; }},
    {"bias", true, [](const Metrics& m) { return std::abs(m.bias); }},
    {"relbias", true, [](const Metrics& m) { return std::abs(m.relative_bias); }},
    {"nonfinite", true, [](const Metrics& m) { return static_cast<double>(m.non_finite_test + m.non_finite_reference); }},
    {"psnr", false, [](const Metrics& m) { return m.psnr; }},
    {"ssim", false, [](const Metrics& m) { return m.ssim; }},
}};
// clang-format on

const MetricRow* find_metric(const std::string& name) {
  const auto row =
      std::find_if(kMetricRows.begin(), kMetricRows.end(), [&](const MetricRow& r) { return r.name == name; });
  return row == kMetricRows.end() ? nullptr : &*row;
}

LimitOutcome evaluate(const Limit& limit, const Metrics& metrics) {
  LimitOutcome outcome{limit, find_metric(limit.metric)->value(metrics), false};
  // Written so that NaN keeps no limit.
  outcome.kept = limit.upper ? outcome.value <= limit.value : outcome.value >= limit.value;
  return outcome;
}

constexpr std::array<const char*, 3> kChannelNames{"red", "green", "blue"};

/// Pictures of one scene with one seed share their noise: the tests then see less than there is.
void note_dependence(const Image& test, const Image& reference, Comparison& c) {
  const auto same = [&](const char* name) {
    const auto a = test.metadata.find(name), b = reference.metadata.find(name);
    return a != test.metadata.end() && b != reference.metadata.end() && a->second == b->second;
  };
  c.tests->shared_noise = same("seed") && same("sceneHash");
  if (c.tests->shared_noise) {
    c.notes.push_back(
        "both pictures were rendered with the same seed: they share their noise, so that the tests are "
        "conservative; render one with another --seed");
  } else if (c.tests->spread.too_small && !c.tests->passed()) {
    c.notes.push_back(spread_text(c.tests->spread));
  }
}

/// What is computed: FLIP of large pictures takes minutes, so it is left out, with a note, unless a limit asks for it.
MetricOptions metrics_wanted(const CompareOptions& options, std::size_t pixels, std::vector<std::string>& notes) {
  const auto limited = [&](const char* metric) {
    return std::ranges::any_of(options.limits, [&](const Limit& limit) { return limit.metric == metric; });
  };
  MetricOptions wanted = options.metrics;
  if (wanted.flip && pixels > kMostFlipPixels) {
    wanted.flip = wanted.hdr_flip = false;
    notes.push_back(fmt::format("FLIP is left out: it takes minutes for {} megapixels; --fail-above flip=… computes it",
                                pixels >> 20));
  } else if (wanted.flip && pixels > kMostHdrFlipPixels) {
    wanted.hdr_flip = false;
    notes.push_back(fmt::format(
        "HDR-FLIP is left out: it takes long for {} megapixels; --fail-above hdrflip=… computes it", pixels >> 20));
  }
  if (limited("hdrflip")) wanted.flip = wanted.hdr_flip = true;
  if (limited("flip")) wanted.flip = true;
  return wanted;
}

Verdict judge(const Image& test, const Image& reference, const Comparison& c) {
  // A NaN is never equal, not even to itself: it is an error in the picture.
  if (c.metrics.non_finite_test + c.metrics.non_finite_reference > 0) return Verdict::different;
  if (test.pixels == reference.pixels) return Verdict::identical;
  if (!c.tests) return Verdict::untested;
  if (!c.tests->passed()) return Verdict::different;
  return c.tests->made() ? Verdict::statistically_equal : Verdict::untested;
}

std::string reason_for_no_test(const Image& test, const Image& reference, const Comparison& c) {
  if (c.verdict != Verdict::untested) return "";
  for (const auto& [name, image] : {std::pair("A", &test), {"B", &reference}}) {
    if (image->metadata.contains(kDenoisedKey))
      return fmt::format(
          "{} is denoised: its error is not random, so it cannot be tested; --fail-above and --fail-below "
          "judge by distances instead",
          name);
  }
  if (c.tests) return c.tests->gap();
  const bool neither = !test.has_statistics() && !reference.has_statistics();
  return fmt::format("{} no standard errors; --fail-above and --fail-below judge by distances instead",
                     neither ? "the pictures have" : fmt::format("{} has", test.has_statistics() ? "B" : "A"));
}

Json interval_json(const Interval& i) {
  return {i.low, i.high};
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::identical:
      return "identical";
    case Verdict::rounding_only:
      return "rounding only";
    case Verdict::statistically_equal:
      return "statistically equal";
    case Verdict::different:
      return "different";
    case Verdict::untested:
      return "not tested";
  }
  return "";
}

Limit parse_limit(const std::string& text, bool upper) {
  const char* option = upper ? "--fail-above" : "--fail-below";
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  const MetricRow* row = find_metric(name);
  if (!row || equals == std::string::npos) {
    std::string names;
    for (const MetricRow& r : kMetricRows) names += fmt::format("{}{}", names.empty() ? "" : ", ", r.name);
    throw Error(ErrorKind::usage,
                fmt::format("{} '{}': expected METRIC=VALUE with a metric out of {}", option, text, names));
  }
  if (row->upper != upper) {
    throw Error(ErrorKind::usage,
                fmt::format("{} '{}': {} {} with likeness; use {}", option, text, name, row->upper ? "falls" : "grows",
                            row->upper ? "--fail-above" : "--fail-below"));
  }
  Limit limit{name, 0.0, upper};
  const char *begin = text.data() + equals + 1, *end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, limit.value);
  if (error != std::errc() || stop != end || !std::isfinite(limit.value)) {
    throw Error(ErrorKind::usage, fmt::format("{} '{}': '{}' is not a number", option, text, std::string(begin, end)));
  }
  return limit;
}

bool Comparison::passed() const {
  if (!std::all_of(limits.begin(), limits.end(), [](const LimitOutcome& l) { return l.kept; })) return false;
  if (verdict == Verdict::untested) return allow_untested || !limits.empty();
  return verdict != Verdict::different;
}

Comparison compare_images(const Image& test, const std::string& test_name, const Image& reference,
                          const std::string& reference_name, const CompareOptions& options) {
  Comparison c;
  c.test_name = test_name;
  c.reference_name = reference_name;
  c.width = test.width;
  c.height = test.height;
  c.metrics = compute_metrics(test, reference, metrics_wanted(options, test.pixels.size(), c.notes));
  if (test.has_statistics() && reference.has_statistics()) {
    c.tests = test_images(test, reference, options.significance);
    note_dependence(test, reference, c);
  }
  for (const Limit& limit : options.limits) c.limits.push_back(evaluate(limit, c.metrics));
  c.metadata = metadata_differences(test.metadata, reference.metadata);
  c.verdict = judge(test, reference, c);
  c.untested_why = reason_for_no_test(test, reference, c);
  c.allow_untested = options.allow_untested;
  return c;
}

std::vector<MetadataDifference> metadata_differences(const Metadata& test, const Metadata& reference) {
  std::set<std::string> names;
  for (const auto& [name, value] : test) names.insert(name);
  for (const auto& [name, value] : reference) names.insert(name);
  std::vector<MetadataDifference> differences;
  for (const std::string& name : names) {
    const auto a = test.find(name), b = reference.find(name);
    const std::string va = a == test.end() ? "" : a->second, vb = b == reference.end() ? "" : b->second;
    constexpr std::size_t kMostShown = 1000;  // headers may hold megabytes
    if (va != vb)
      differences.push_back(
          {text::printable(name, kMostShown), text::printable(va, kMostShown), text::printable(vb, kMostShown)});
  }
  return differences;
}

std::string image_tests_text(const ImageTests& tests) {
  std::string out = fmt::format("{:<12} {:>9} {:>11} {:>11} {:>9} {:>8}  worst\n", "tests of", "number", "smallest p",
                                "family p", "rejected", "z spread");
  for (const TestFamily& f : tests.families) {
    if (f.tests == 0) {
      out += fmt::format("{:<12} {:>9} (each needs {} samples)\n", f.name, "none",
                         f.name == "pixels" ? kMinPixelSamples : 2);
      continue;
    }
    out += fmt::format(
        "{:<12} {:>9} {:>11.3g} {:>11.3g} {:>9} {:>8.3f}  ({}, {}) {}: {:.6g} against {:.6g}, z = {:.2f}{}\n", f.name,
        f.tests, f.smallest_p, f.family_p, f.rejected, f.z_deviation, f.worst_x, f.worst_y,
        kChannelNames[static_cast<std::size_t>(f.worst_channel)], f.worst_test, f.worst_reference, f.worst_z,
        f.passed() ? "" : "  FAILED");
  }
  out += fmt::format("false-alarm rate {:.3g} for all tests together ({:.3g} a family, Šidák inside each); {}\n",
                     tests.significance, tests.significance / 3.0,
                     std::isinf(tests.detectable_bias)
                         ? "no pixel could be tested"
                         : fmt::format("a bias of {:.3g} % of the image mean would be found with probability 0.99",
                                       100.0 * tests.detectable_bias));
  return out;
}

std::string comparison_text(const Comparison& c) {
  const Metrics& m = c.metrics;
  std::string out = fmt::format("{} against {}, {}×{}\n", text::printable(c.test_name, text::kLongestLine),
                                text::printable(c.reference_name, text::kLongestLine), c.width, c.height);
  out += fmt::format("MSE {:.4g}  RMSE {:.4g}  relMSE {:.4g}  MAE {:.4g}  PSNR {:.2f} dB  SSIM {:.5f}", m.mse, m.rmse,
                     m.rel_mse, m.mae, m.psnr, m.ssim);
  if (!std::isnan(m.flip)) out += fmt::format("  FLIP {:.5f}", m.flip);
  if (!std::isnan(m.hdr_flip)) out += fmt::format("  HDR-FLIP {:.5f}", m.hdr_flip);
  out += fmt::format(
      "\nbias of the luminance {:+.4g} [{:+.4g}, {:+.4g}], {:+.3g} % [{:+.3g}, {:+.3g}], {:.3g} % confidence {}\n",
      m.bias, m.bias_interval.low, m.bias_interval.high, 100 * m.relative_bias, 100 * m.relative_bias_interval.low,
      100 * m.relative_bias_interval.high, 100 * m.bias_level,
      m.bias_from_errors ? "from the standard errors" : "from the spread of the pixel differences");
  if (m.non_finite_test + m.non_finite_reference > 0) {
    out += fmt::format("{} and {} pixels are NaN or infinite; they are left out of the distances\n", m.non_finite_test,
                       m.non_finite_reference);
  }
  if (c.tests) out += image_tests_text(*c.tests);
  for (const std::string& note : c.notes) out += "note: " + note + "\n";
  for (const LimitOutcome& l : c.limits) {
    out += fmt::format("{} = {:.6g}, limit {} {:.6g}: {}\n", l.limit.metric, l.value, l.limit.upper ? "≤" : "≥",
                       l.limit.value, l.kept ? "kept" : "FAILED");
  }
  out += fmt::format("verdict: {}{}\n", verdict_name(c.verdict),
                     c.untested_why.empty() ? "" : fmt::format(": {}", c.untested_why));
  return out;
}

Json image_tests_json(const ImageTests& tests) {
  Json families = Json::array();
  for (const TestFamily& f : tests.families) {
    families.push_back({{"name", f.name},
                        {"tests", f.tests},
                        {"skipped", f.skipped},
                        {"familyLevel", f.family_level},
                        {"testLevel", f.test_level},
                        {"smallestP", f.smallest_p},
                        {"familyP", f.family_p},
                        {"rejectedByHolm", f.rejected},
                        {"zMean", f.z_mean},
                        {"zDeviation", f.z_deviation},
                        {"worst",
                         {{"x", f.worst_x},
                          {"y", f.worst_y},
                          {"channel", kChannelNames[static_cast<std::size_t>(f.worst_channel)]},
                          {"test", f.worst_test},
                          {"reference", f.worst_reference},
                          {"z", f.worst_z}}},
                        {"passed", f.passed()}});
  }
  return {{"significance", tests.significance},
          {"families", families},
          {"detectableRelativeBias", tests.detectable_bias},
          {"pixels", tests.pixels},
          {"differingPixels", tests.differing},
          {"untestedPixels", tests.untested},
          {"scoredPixels", tests.spread.pixels},
          {"meanSquareScore", tests.spread.mean_square},
          {"errorsTooLarge", tests.spread.too_small},
          {"sharedNoise", tests.shared_noise},
          {"made", tests.made()},
          {"passed", tests.passed()}};
}

Json comparison_json(const Comparison& c) {
  const Metrics& m = c.metrics;
  Json metrics;
  for (const MetricRow& row : kMetricRows) metrics[row.name] = row.value(m);  // infinity and NaN become null
  metrics["bias"] = m.bias;
  metrics["biasInterval"] = interval_json(m.bias_interval);
  metrics["relbias"] = m.relative_bias;
  metrics["relbiasInterval"] = interval_json(m.relative_bias_interval);
  metrics["biasLevel"] = m.bias_level;
  metrics["biasFrom"] = m.bias_from_errors ? "standard errors" : "pixel differences";
  Json limits = Json::array(), metadata = Json::array();
  for (const LimitOutcome& l : c.limits) {
    limits.push_back({{"metric", l.limit.metric},
                      {"limit", l.limit.value},
                      {"side", l.limit.upper ? "above" : "below"},
                      {"value", l.value},
                      {"kept", l.kept}});
  }
  for (const MetadataDifference& d : c.metadata) {
    metadata.push_back({{"name", d.name}, {"test", d.test}, {"reference", d.reference}});
  }
  Json out = {{"test", c.test_name},
              {"reference", c.reference_name},
              {"width", c.width},
              {"height", c.height},
              {"metrics", metrics},
              {"limits", limits},
              {"metadata", metadata},
              {"notes", c.notes},
              {"verdict", verdict_name(c.verdict)},
              {"untestedWhy", c.untested_why},
              {"passed", c.passed()}};
  if (c.tests) out["tests"] = image_tests_json(*c.tests);
  return out;
}

JunitCase comparison_junit(const Comparison& c) {
  JunitCase junit;
  junit.name = c.test_name + " against " + c.reference_name;
  junit.failed = !c.passed();
  junit.skipped = c.passed() && c.verdict == Verdict::untested && c.limits.empty();
  junit.message = fmt::format("verdict: {}{}", verdict_name(c.verdict),
                              c.untested_why.empty() ? "" : fmt::format(": {}", c.untested_why));
  for (const LimitOutcome& l : c.limits) {
    if (!l.kept)
      junit.message += fmt::format("; {} = {:.6g} breaks its limit {:.6g}", l.limit.metric, l.value, l.limit.value);
  }
  junit.details = comparison_text(c);
  return junit;
}

std::string json_text(const Json& json) {
  return json.dump(2) + "\n";
}

}  // namespace etendue
