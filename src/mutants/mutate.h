#pragma once
/// The mutation test: do the tests notice an error? The device renders with kernels that have one planted error each
/// (shaders/mutants.h). The suite must find every error, and none in the kernels without one.

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/json.h"
#include "gpu/gpu_renderer.h"
#include "gpu/kernel_set.h"
#include "validate/junit.h"

namespace etendue {

struct Mutant {
  std::uint32_t id = 0;
  std::string_view name;
  std::string_view what;
  std::string_view try_first;  ///< beginning of the name of a test that is known to notice it
};
/// All mutants by id; the first one, 0, has no error.
std::span<const Mutant> mutants();

/// The kernels with an error; for 0, the same kernels without one.
KernelSet kernels_with(std::uint32_t mutant);

struct MutateOptions {
  GpuOptions gpu;
  bool all_tests = false;           ///< run all tests on every mutant instead of stopping at the first that notices
  std::vector<std::uint32_t> only;  ///< ids; empty: all
  double level = 1e-6;              ///< false-alarm rate of one look of one test
  std::function<void(const struct MutantOutcome&)> progress;  ///< called after each mutant, if set
};

/// The result of one test for one mutant.
struct MutantFinding {
  std::string test;
  bool caught = false;
  std::uint64_t samples = 0;  ///< number of samples used
  double p_value = 1;
};

struct MutantOutcome {
  Mutant mutant;
  std::vector<MutantFinding> findings;  ///< in the order of the tests
  double seconds = 0;
  bool caught() const;
  /// Whether an error was caught, or for the kernels without an error, whether no test complained.
  bool passed() const { return caught() == (mutant.id != 0); }
};

struct MutateReport {
  std::string device, driver;
  double level = 0;
  std::vector<MutantOutcome> mutants;
  bool passed() const;
};

/// Throws Error(usage) for an unknown id, and errors of the device.
MutateReport run_mutate(const MutateOptions& options);

std::string mutate_text(const MutateReport& report);
/// The table in docs/validation.md.
std::string mutate_markdown(const MutateReport& report);
Json mutate_json(const MutateReport& report);
std::vector<JunitCase> mutate_junit(const MutateReport& report);

}  // namespace etendue
