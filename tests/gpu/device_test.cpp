#include "device_test.h"

#include <algorithm>

#include "compile/node_layout.h"
#include "core/errors.h"
#include "gpu/device_scene.h"
#include "gpu/device_view.h"
#include "validate/statistics.h"

namespace etendue::test {
namespace {

// ETENDUE_VALIDATION=2 adds synchronization and GPU-assisted validation.
const vulkan::ContextOptions kValidation = [] {
  vulkan::ContextOptions options = gpu_context_options();
  options.validation = true;
  return options;
}();

// Opened once; `reason` tells why there is none.
std::shared_ptr<GpuDevice> device(std::string* reason = nullptr) {
  static std::string failure;
  static const std::shared_ptr<GpuDevice> opened = []() -> std::shared_ptr<GpuDevice> {
    try {
      return std::make_shared<GpuDevice>(std::make_shared<const vulkan::Context>("auto", kValidation));
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::device) throw;
      failure = error.what();
      return nullptr;
    }
  }();
  if (reason != nullptr) *reason = failure;
  return opened;
}

}  // namespace

CompiledScene list_primitives(CompiledScene scene) {
  const auto list = [&](std::uint32_t slot) { scene.vertex_normals.push_back({slot, 0, 0, gpu::kListed}); };
  for (std::uint32_t i = 0; i < scene.few_count; ++i) list(i * gpu::kPrimitiveSlots);
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
  return device()->context->info().name.find("llvmpipe") != std::string::npos;
}

void DeviceTest::run_bytes(const KernelRun& run, std::span<const std::byte> inputs, std::span<std::byte> outputs,
                           std::uint32_t lanes) {
  GpuDevice& d = *device();
  static const CompiledScene empty = compile_scene(Scene{});
  const CompiledScene& compiled = run.scene != nullptr ? *run.scene : empty;
  // Lives longer than its use here, whoever owns it.
  const DeviceScene scene(device(), std::shared_ptr<const CompiledScene>(std::shared_ptr<void>(), &compiled),
                          run.loads);
  DeviceView view(d);
  view.set(d, compile_view(SceneFacts(compiled), run.view.value_or(view_of(Scene{})), 0));
  const auto buffer = [&](std::size_t bytes, const char* what) {
    return vulkan::Buffer(*d.context, bytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Buffer::Memory::device, what);
  };
  const vulkan::Buffer in = buffer(inputs.size(), "test inputs");
  const vulkan::Buffer out = buffer(outputs.size(), "test outputs");
  d.commands.upload(in, 0, inputs);
  d.commands.fill(out, 0xdeadbeefu);  // a lane that writes nothing shows
  vulkan::BindingSet set(*d.context, scene.request_kernels().set);
  view.bind(set);
  set.bind(gpu::kBindingRequests, in);
  set.bind(gpu::kBindingResults, out);
  std::vector<vulkan::Specialization> constants = run.constants;
  if (run.scene != nullptr) {  // without one the kernels keep their defaults, which leave nothing out
    constants.insert(constants.end(), scene.constants().begin(), scene.constants().end());
    constants.push_back({gpu::kConstantLightTreeDepth, scene.light_tree_depth()});
  }
  const vulkan::Kernel kernel(*d.context, scene.request_kernels().pipeline, run.spirv, constants, run.name);
  gpu::Pass pass{};
  pass.request_count = lanes;
  const std::uint32_t groups = (lanes + gpu::kWorkgroupSize - 1) / gpu::kWorkgroupSize;
  d.commands.dispatch(scene.request_kernels().pipeline, kernel, {&scene.set(), &set},
                      std::as_bytes(std::span(&pass, 1)), groups, 120.0);
  d.commands.download(out, 0, outputs);
}

double uniformity(const std::vector<double>& counts) {
  double total = 0.0;
  for (const double c : counts) total += c;
  const std::vector<double> expected(counts.size(), total / static_cast<double>(counts.size()));
  return chi_square_test(counts, expected).p_value;
}

}  // namespace etendue::test
