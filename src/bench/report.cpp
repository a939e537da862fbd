#include "bench/report.h"

#include <algorithm>
#include <fstream>
#include <variant>

#include <fmt/core.h>

#include "core/printable.h"
#include "core/version.h"

namespace etendue {
namespace {

// "12.3 (11.8 - 12.9)" in units of `unit`; a dash where nothing was measured.
std::string text(const Spread& s, double unit) {
  if (s.count == 0) return "-";
  const double median = s.median / unit;
  const int digits = median >= 100.0 ? 0 : median >= 10.0 ? 1 : median >= 1.0 ? 2 : 3;
  return fmt::format("{:.{}f} ({:.{}f} - {:.{}f})", median, digits, s.min / unit, digits, s.max / unit, digits);
}

std::string mebibytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} MiB", static_cast<double>(bytes) / 0x1p20);
}

std::string ray_line(const RayRates& r) {
  std::string check;
  if (r.check) {
    check = fmt::format("{} of {} checked differ", r.check->differ, r.check->checked);
    if (r.check->wrong > 0) check += fmt::format(", {} are WRONG", r.check->wrong);
  }
  return fmt::format("  {:<20} {:>26}  {:>7} rays, {:5.1f} % hit, {:5.1f} steps  {}\n",
                     r.shuffled ? r.kind + ", shuffled" : r.kind, text(r.rate, 1e6), r.count,
                     100.0 * static_cast<double>(r.hits) / static_cast<double>(std::max<std::size_t>(r.count, 1)),
                     r.steps, check);
}

Json json(const Spread& s) {
  if (s.count == 0) return nullptr;
  return {{"median", s.median}, {"min", s.min}, {"max", s.max}, {"count", s.count}};
}

Json json(const RayRates& r) {
  Json out = {{"class", r.kind},
              {"order", r.shuffled ? "shuffled" : "picture"},
              {"rays", r.count},
              {"hits", r.hits},
              {"steps_per_ray", r.steps > 0.0 ? Json(r.steps) : Json()},
              {"rays_per_second", json(r.rate)},
              {"rays_per_cpu_second", json(r.cpu_rate)},
              {"check", nullptr}};
  if (r.check) {
    out["check"] = {{"rays", r.check->checked},
                    {"hits", r.check->hits},
                    {"differ", r.check->differ},
                    {"wrong", r.check->wrong},
                    {"largest_error", r.check->largest_error},
                    {"passed", r.check->passed()}};
  }
  return out;
}

Json json(const KernelReport& kernel) {
  Json parts = Json::array();
  for (const vulkan::KernelStatistics& part : kernel.parts) {
    Json values = Json::object();
    for (const auto& [name, value] : part.values)
      std::visit([&](auto number) { values[text::printable(name, text::kLongestLine)] = number; }, value);
    parts.push_back({{"part", text::printable(part.part, text::kLongestLine)},
                     {"subgroup_size", part.subgroup_size},
                     {"statistics", values}});
  }
  return {{"kernel", kernel.kernel}, {"parts", parts}};
}

std::string kernel_lines(const KernelReport& kernel) {
  std::string out;
  for (const vulkan::KernelStatistics& part : kernel.parts) {
    out += fmt::format("  kernel {}, {}, subgroups of {}\n", kernel.kernel,
                       text::printable(part.part, text::kLongestLine), part.subgroup_size);
    for (const auto& [name, value] : part.values)
      std::visit(
          [&](auto number) {
            out += fmt::format("    {:<28} {:>16}\n", text::printable(name, text::kLongestLine), number);
          },
          value);
  }
  return out;
}

Json json(const SceneReport& s) {
  Json out = {{"scene", s.name},
              {"file", s.file},
              {"integrator", s.integrator},
              {"width", s.width},
              {"height", s.height},
              {"triangles", s.triangles},
              {"spheres", s.spheres},
              {"seconds",
               {{"compile", json(s.compile)},
                {"upload", json(s.upload)},
                {"pipeline_cold", json(s.pipeline_cold)},
                {"pipeline_warm", json(s.pipeline_warm)}}},
              {"memory", {{"host_peak", nullptr}, {"device_peak", nullptr}}},
              {"rays", Json::array()},
              {"samples_per_second", json(s.sample_rate)},
              {"samples_per_cpu_second", json(s.cpu_sample_rate)},
              {"spp", s.repeated_spp}};
  if (s.host_peak) out["memory"]["host_peak"] = *s.host_peak;
  if (s.device_peak > 0) out["memory"]["device_peak"] = s.device_peak;
  for (const RayRates& r : s.rays) out["rays"].push_back(json(r));
  if (s.kernels.empty()) return out;
  out["compiler"] = text::printable(s.compiler, text::kLongestLine);
  out["kernels"] = Json::array();
  for (const KernelReport& kernel : s.kernels) out["kernels"].push_back(json(kernel));
  return out;
}

std::string scene_table(const SceneReport& s) {
  std::string out = fmt::format("\n{}: {} triangles, {} spheres\n", text::printable(s.name, text::kLongestLine),
                                s.triangles, s.spheres);
  if (s.compile.count > 0) {
    out += fmt::format("  {:<20} {:>26}\n", "tree etc., ms", text(s.compile, 1e-3));
    out += fmt::format("  {:<20} {:>26}\n", "upload, ms", text(s.upload, 1e-3));
    out += fmt::format("  {:<20} {:>26}\n", "kernel, ms", text(s.pipeline_cold, 1e-3));
    out += fmt::format("  {:<20} {:>26}\n", "kernel, cached, ms", text(s.pipeline_warm, 1e-3));
  }
  if (s.host_peak)
    out += fmt::format("  {:<20} {:>26}  above the scene itself\n", "host memory", mebibytes(*s.host_peak));
  if (s.device_peak > 0) out += fmt::format("  {:<20} {:>26}\n", "device memory", mebibytes(s.device_peak));
  if (!s.kernels.empty()) out += fmt::format("  kernels by {}\n", text::printable(s.compiler, text::kLongestLine));
  for (const KernelReport& kernel : s.kernels) out += kernel_lines(kernel);
  if (!s.rays.empty()) out += fmt::format("  {:<20} {:>26}\n", "rays", "Mrays/s");
  for (const RayRates& r : s.rays) out += ray_line(r);
  if (s.sample_rate.count > 0) {
    out += fmt::format("  {:<20} {:>26}  {}, {}x{}, {} spp each time\n", "samples, Msamples/s",
                       text(s.sample_rate, 1e6), s.integrator, s.width, s.height, s.repeated_spp);
  }
  return out;
}

}  // namespace

bool BenchReport::passed() const {
  return std::ranges::all_of(scenes, &SceneReport::passed);
}

std::string bench_table(const BenchReport& report) {
  std::string out = fmt::format("{}, {}; {}, {} threads; median (min - max) of {} repetitions\n", report.device,
                                report.driver, report.processor, report.host_threads, report.repetitions);
  for (const SceneReport& scene : report.scenes) out += scene_table(scene);
  return out;
}

Json bench_json(const BenchReport& report) {
  Json out = {{"version", version()},
              {"device", report.device},
              {"driver", report.driver},
              {"processor", report.processor},
              {"host_threads", report.host_threads},
              {"repetitions", report.repetitions},
              {"passed", report.passed()},
              {"scenes", Json::array()}};
  for (const SceneReport& scene : report.scenes) out["scenes"].push_back(json(scene));
  return out;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "";
}

}  // namespace etendue
