#include "device_test.h"

#include <algorithm>

#include "compile/node_layout.h"
#include "core/errors.h"
#include "gpu/device_scene.h"
#include "validate/statistics.h"

namespace etendue::test {
namespace {

// ETENDUE_VALIDATION=2 adds synchronization and GPU-assisted validation.
const vulkan::ContextOptions kValidation{
    .validation = true, .validation_extra = vulkan::ContextOptions::from_environment().validation_extra};

struct Device {
  Device()
      : context("auto", kValidation),
        commands(context),
        texels(context, kernel_bindings(TableLoads::texel_buffer), sizeof(gpu::Pass)),
        storage(context, kernel_bindings(TableLoads::storage_buffer), sizeof(gpu::Pass)) {}
  vulkan::Context context;
  vulkan::Commands commands;
  vulkan::BindingLayout texels, storage;
};

// Opened once; `reason` tells why there is none.
Device* device(std::string* reason = nullptr) {
  static std::string failure;
  static const std::unique_ptr<Device> opened = []() -> std::unique_ptr<Device> {
    try {
      return std::make_unique<Device>();
    } catch (const Error& error) {
      if (error.code() != ExitCode::no_device) throw;
      failure = error.what();
      return nullptr;
    }
  }();
  if (reason != nullptr) *reason = failure;
  return opened.get();
}

}  // namespace

CompiledScene list_primitives(CompiledScene scene) {
  const auto list = [&](std::uint32_t slot) { scene.triangles.push_back({slot, 0, 0, gpu::kListed}); };
  for (std::uint32_t i = 0; i < scene.few_triangles + scene.few_spheres; ++i) list(i * gpu::kPrimitiveSlots);
  const TreeReader<gpu::kBvhWidth> tree(scene.records);
  std::vector<std::uint32_t> pending;
  if (scene.tree_root != gpu::kNone) pending.push_back(scene.tree_root);
  while (!pending.empty()) {
    const std::uint32_t slot = pending.back();
    pending.pop_back();
    if (!tree.is_node(slot)) {
      list(slot);
      continue;
    }
    for (std::uint32_t i = 0; i < tree.child_count(slot); ++i) pending.push_back(tree.child_slot(slot, i));
  }
  return scene;
}

void DeviceTest::SetUp() {
  std::string reason;
  if (device(&reason) == nullptr) GTEST_SKIP() << reason;
  messages_before_ = vulkan::validation_message_count();
}

void DeviceTest::TearDown() {
  EXPECT_EQ(vulkan::validation_message_count(), messages_before_)
      << "the validation layer had something to say, see above";
}

GpuOptions DeviceTest::renderer_options() {
  GpuOptions options;
  options.context = kValidation;
  return options;
}

bool DeviceTest::is_lavapipe() {
  return device()->context.info().name.find("llvmpipe") != std::string::npos;
}

void DeviceTest::run_bytes(const KernelRun& run, std::span<const std::byte> inputs, std::span<std::byte> outputs,
                           std::uint32_t lanes) {
  Device& d = *device();
  static const CompiledScene empty = compile_scene(Scene{});
  const CompiledScene& compiled = run.scene != nullptr ? *run.scene : empty;
  const vulkan::BindingLayout& layout = run.loads == TableLoads::texel_buffer ? d.texels : d.storage;
  const DeviceScene scene(d.context, d.commands, compiled, run.loads);
  const auto buffer = [&](std::size_t bytes, const char* what) {
    return vulkan::Buffer(d.context, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Buffer::Memory::device, what);
  };
  const vulkan::Buffer in = buffer(inputs.size(), "test inputs");
  const vulkan::Buffer out = buffer(outputs.size(), "test outputs");
  d.commands.upload(in, 0, inputs);
  d.commands.fill(out, 0xdeadbeefu);  // a lane that writes nothing shows
  vulkan::BindingSet set(d.context, layout);
  scene.bind(set);
  set.bind(gpu::kBindingRequests, in);
  set.bind(gpu::kBindingResults, out);
  std::vector<vulkan::Specialization> constants = run.constants;
  if (run.scene != nullptr) {  // without one the kernels keep their defaults, which leave nothing out
    const std::vector<vulkan::Specialization> scene_values = scene_constants(compiled);
    constants.insert(constants.end(), scene_values.begin(), scene_values.end());
  }
  const vulkan::Kernel kernel(d.context, layout, run.spirv, constants, run.name);
  gpu::Pass pass{};
  pass.request_count = lanes;
  const std::uint32_t groups = (lanes + gpu::kWorkgroupSize - 1) / gpu::kWorkgroupSize;
  d.commands.dispatch(layout, kernel, set, std::as_bytes(std::span(&pass, 1)), groups, 120.0);
  d.commands.download(out, 0, outputs);
}

double uniformity(const std::vector<double>& counts) {
  double total = 0.0;
  for (const double c : counts) total += c;
  const std::vector<double> expected(counts.size(), total / static_cast<double>(counts.size()));
  return chi_square_test(counts, expected).p_value;
}

}  // namespace etendue::test
