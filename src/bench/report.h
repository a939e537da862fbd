#pragma once
/// The measurements, for people and for programs.

#include <string>
#include <vector>

#include "bench/scene_bench.h"
#include "core/json.h"

namespace etendue {

struct BenchReport {
  std::string device, driver;
  std::string processor;  ///< model name of the host's CPU
  unsigned host_threads = 0;
  std::uint32_t repetitions = 0;
  std::vector<SceneReport> scenes;
  bool passed() const;
};

std::string bench_table(const BenchReport& report);
Json bench_json(const BenchReport& report);

/// The CPU's model name as Linux gives it; empty where it does not.
std::string processor_name();

}  // namespace etendue
