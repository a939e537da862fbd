#pragma once
/// One Vulkan device for all tests of the process, and a way to run a test kernel on it: lane i maps inputs[i] to
/// outputs[i].

#include <cstdint>
#include <cstring>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "compile/compiled_scene.h"
#include "gpu/gpu_renderer.h"
#include "kernels.h"
#include "test_types.h"
#include "vulkan/commands.h"

namespace etendue::test {

/// What a kernel is run with, apart from its inputs.
struct KernelRun {
  std::span<const std::uint32_t> spirv;
  const char* name = "";
  const CompiledScene* scene = nullptr;  ///< nullptr: an empty scene is bound
  std::vector<vulkan::Specialization> constants;
  TableLoads loads = TableLoads::texel_buffer;  ///< what the kernel was built for
  std::optional<View> view = {};                ///< nothing: that of an empty scene
};

/// The scene with the slots of all its primitives appended to the triangle indices, where brute_force.glsl finds them:
/// those that the tree's nodes name, boxes left aside. Unit tests show that nodes name every primitive once.
CompiledScene list_primitives(CompiledScene scene);

/// Skips without a device; fails when the validation layer says anything during the test.
class DeviceTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  /// Runs the kernel for every input. `inputs_per_lane` inputs make one output.
  template <typename Out, typename In>
  std::vector<Out> run(const KernelRun& kernel, const std::vector<In>& inputs, std::uint32_t inputs_per_lane = 1) {
    std::vector<Out> outputs(inputs.size() / inputs_per_lane);
    run_bytes(kernel, std::as_bytes(std::span(inputs)), std::as_writable_bytes(std::span(outputs)),
              static_cast<std::uint32_t>(outputs.size()));
    return outputs;
  }

  /// Options for renderers under test: a device opened for each, the validation layer on.
  static GpuOptions renderer_options();
  /// True on Mesa's CPU driver, whose float arithmetic is known to be exact where Vulkan leaves freedom.
  static bool is_lavapipe();

 private:
  static void run_bytes(const KernelRun& kernel, std::span<const std::byte> inputs, std::span<std::byte> outputs,
                        std::uint32_t lanes);
  std::uint64_t messages_before_ = 0;
};

/// Random numbers of the tests: fixed seeds, so that a verdict repeats.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// [0,1), a multiple of 2^-24 like the numbers of the sampler.
  float unit() { return static_cast<float>(engine_() >> 40) * 0x1p-24f; }
  float uniform(float low, float high) { return low + (high - low) * unit(); }
  std::uint32_t word() { return static_cast<std::uint32_t>(engine_() >> 32); }
  std::uint32_t below(std::uint32_t n) {
    return static_cast<std::uint32_t>(static_cast<std::uint64_t>(word()) * n >> 32);
  }
  glm::vec3 point(float half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
  /// Uniform on the sphere.
  glm::dvec3 direction() {
    std::normal_distribution<double> normal;
    const double x = normal(engine_), y = normal(engine_), z = normal(engine_);
    return glm::normalize(glm::dvec3(x, y, z));
  }

 private:
  std::mt19937_64 engine_;
};

/// p-value of counts that should be equal in expectation (Pearson).
double uniformity(const std::vector<double>& counts);

/// Below this a statistical test of the suite fails. Seeds are fixed; for a new device the chance of a false alarm is
/// that of about 100 tests, 1e-3 in all.
inline constexpr double kSmallestP = 1e-5;

}  // namespace etendue::test
