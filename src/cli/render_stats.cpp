#include "cli/render_stats.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/core.h>

#include "core/log.h"

namespace etendue::cli {
namespace {

struct RayClass {
  const char* name;
  RayCounts counts;
};

std::array<RayClass, 3> classes(const RenderProfile& p) {
  return {{{"camera", p.camera}, {"scattered", p.scattered}, {"shadow", p.shadow}}};
}

double ratio(std::uint64_t part, double whole) {
  return whole > 0.0 ? static_cast<double>(part) / whole : 0.0;
}

double samples(const RenderProfile& p) {
  return static_cast<double>(p.samples) * p.width * p.height;
}

Json json(const std::optional<double>& value) {
  return value ? Json(*value) : Json();
}

// Linear from an sRGB component, IEC 61966-2-1.
double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

// Colours at equal steps from 0 to 1, in sRGB. Their lightness increases throughout, so the order is also visible in
// grey.
constexpr std::array<std::array<double, 3>, 6> kRamp = {
    {{0.0, 0.0, 0.0}, {0.24, 0.06, 0.44}, {0.62, 0.14, 0.42}, {0.92, 0.38, 0.20}, {0.98, 0.75, 0.20}, {1.0, 1.0, 1.0}}};

glm::vec3 ramp(double x) {
  const double at = std::clamp(x, 0.0, 1.0) * (kRamp.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kRamp.size() - 2);
  glm::vec3 color;
  for (int c = 0; c < 3; ++c)
    color[c] = static_cast<float>(linear(std::lerp(kRamp[i][c], kRamp[i + 1][c], at - static_cast<double>(i))));
  return color;
}

}  // namespace

std::string stats_text(const RenderProfile& p, const GpuTimings& t) {
  std::string out = fmt::format("counted on {} samples of each pixel\n{:<10} {:>12} {:>10} {:>15}\n", p.samples, "rays",
                                "per sample", "nodes/ray", "primitives/ray");
  for (const RayClass& c : classes(p)) {
    const auto rays = static_cast<double>(c.counts.rays);
    out += fmt::format("{:<10} {:>12.3f} {:>10.2f} {:>15.2f}\n", c.name, ratio(c.counts.rays, samples(p)),
                       ratio(c.counts.nodes, rays), ratio(c.counts.primitives, rays));
  }
  if (p.walk_utilisation && p.shade_utilisation) {
    out += fmt::format("active lanes: {:.1f} % in the tree, {:.1f} % in shading\n", 100.0 * *p.walk_utilisation,
                       100.0 * *p.shade_utilisation);
  } else {
    out += "active lanes: unknown, the device has no subgroup ballots\n";
  }
  if (t.dispatches > 0) {
    out += fmt::format("{} passes over the film; {} dispatches after the first, {:.3g} s each, the longest {:.3g} s\n",
                       t.passes, t.dispatches, t.render / static_cast<double>(t.dispatches), t.longest);
  } else {
    out += "all in one dispatch, which also compiled the kernel\n";
  }
  return out;
}

Json stats_json(const RenderProfile& p, const GpuTimings& t) {
  Json out = {{"samples", p.samples},
              {"rays", Json::object()},
              {"walk_utilisation", json(p.walk_utilisation)},
              {"shade_utilisation", json(p.shade_utilisation)},
              {"passes", t.passes},
              {"dispatches", t.dispatches},
              {"dispatch_seconds", t.render},
              {"longest_dispatch", t.longest}};
  for (const RayClass& c : classes(p)) {
    const auto rays = static_cast<double>(c.counts.rays);
    out["rays"][c.name] = {{"per_sample", ratio(c.counts.rays, samples(p))},
                           {"nodes", ratio(c.counts.nodes, rays)},
                           {"primitives", ratio(c.counts.primitives, rays)}};
  }
  return out;
}

Image heat_values(const RenderProfile& p) {
  return {.width = p.width,
          .height = p.height,
          .pixels = p.visits,
          .metadata = {{"software", "Etendue"},
                       {"content", "heat map"},
                       {"channels", "R: nodes, G: primitives, B: rays, per sample"},
                       {"heatMapSamples", std::to_string(p.samples)}}};
}

Image heat_colors(const RenderProfile& p, float& white) {
  std::vector<float> visits;
  for (const glm::vec3& v : p.visits) visits.push_back(v.x + v.y);
  std::vector<float> sorted = visits;
  const auto high = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() - 1 - sorted.size() / 200);
  std::ranges::nth_element(sorted, high);
  white = std::max(*high, 1.0f);
  Image image{.width = p.width, .height = p.height, .metadata = {{"software", "Etendue"}, {"content", "heat map"}}};
  for (const float v : visits) image.pixels.push_back(ramp(v / white));
  return image;
}

void write_heat_map(const std::string& path, const RenderProfile& profile) {
  if (path.ends_with(".exr")) return write_exr(path, heat_values(profile));
  float white = 0.0f;
  write_png(path, heat_colors(profile, white));
  log::info(fmt::format("{}: white is {:.4g} nodes and primitives per sample, or more.", path, white));
}

}  // namespace etendue::cli
