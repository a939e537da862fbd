#include "gpu/ray_caster.h"

#include <algorithm>

#include <fmt/core.h>

#include "compile/normalization.h"
#include "core/errors.h"
#include "gpu/device_scene.h"
#include "gpu/kernel_set.h"

namespace etendue {
namespace {

static_assert(sizeof(CastRay) == sizeof(gpu::RayRequest) && sizeof(CastHit) == sizeof(gpu::RayResult));
static_assert(CastHit::kNone == gpu::kNone);

constexpr std::size_t kMostRays = std::size_t{1} << 22;
constexpr double kDispatchTimeout = 60.0;  // seconds
// Steps of one ray. lavapipe ends loops silently after 65 535 iterations of a group of 8 lanes, and walks may be laid
// end to end; a tree of 64 levels is left long before that.
constexpr std::uint32_t kMostSteps = 7500;

class GpuRayCaster final : public RayCaster {
 public:
  GpuRayCaster(const Scene& scene, const GpuOptions& options)
      : placement_(find_placement(scene)), context_(options.device, options.context), commands_(context_) {
    const CompiledScene compiled = compile_scene(scene);
    const TableLoads loads = choose_table_loads(context_, compiled, options.wanted_loads());
    kernels_ = kernel_set(options.mutant, loads);
    layout_.emplace(context_, kernel_bindings(loads), sizeof(gpu::Pass));
    set_.emplace(context_, *layout_);
    scene_ = std::make_unique<DeviceScene>(context_, commands_, compiled, loads);
    constants_ = scene_constants(compiled);
    constants_.insert(constants_.end(), kernels_.constants.begin(), kernels_.constants.end());
    closest_ = make_kernel(RayQuery::closest);
    any_ = make_kernel(RayQuery::any);
    bind(16, 16);
  }

  std::string device_name() const override { return context_.info().name; }
  std::string driver_name() const override { return context_.info().driver; }
  Placement placement() const override { return placement_; }
  std::size_t max_rays() const override {
    const std::size_t per_binding = context_.limits().maxStorageBufferRange / sizeof(CastRay);
    const std::size_t per_dispatch = std::size_t{context_.limits().maxComputeWorkGroupCount[0]} * gpu::kWorkgroupSize;
    return std::min({kMostRays, per_binding, per_dispatch});
  }
  std::size_t enough_rays() const override {
    return std::min(max_rays(), context_.is_cpu() ? std::size_t{1} << 19 : kMostRays);
  }

  void load(std::span<const CastRay> rays) override {
    if (rays.size() > max_rays())
      throw Error(ExitCode::usage, fmt::format("{} rays at a time are more than the {} that '{}' takes.", rays.size(),
                                               max_rays(), context_.info().name));
    if (rays.size() > capacity_) {
      capacity_ = rays.size();
      bind(capacity_ * sizeof(CastRay), capacity_ * sizeof(CastHit));
    }
    commands_.upload(rays_, 0, std::as_bytes(rays));
    count_ = static_cast<std::uint32_t>(rays.size());
  }

  double cast(RayQuery query) override {
    if (count_ == 0) return 0.0;
    gpu::Pass pass{};
    pass.request_count = count_;
    pass.step_budget = kMostSteps;
    const vulkan::Kernel& kernel = query == RayQuery::any ? any_ : closest_;
    return commands_.dispatch(*layout_, kernel, *set_, std::as_bytes(std::span(&pass, 1)),
                              (count_ + gpu::kWorkgroupSize - 1) / gpu::kWorkgroupSize, kDispatchTimeout);
  }

  std::vector<CastHit> hits() override {
    std::vector<CastHit> hits(count_);
    commands_.download(results_, 0, std::as_writable_bytes(std::span(hits)));
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits[i].steps <= kMostSteps) continue;
      throw Error(ExitCode::device_lost,
                  fmt::format("Ray {} needs more than {} steps through the tree, the most a ray may take here.", i,
                              kMostSteps));
    }
    return hits;
  }

 private:
  static Placement find_placement(const Scene& scene) {
    const Normalization n = find_normalization(scene);
    return {n.center, n.scale};
  }
  vulkan::Kernel make_kernel(RayQuery query) {
    std::vector<vulkan::Specialization> constants = constants_;
    constants.push_back({gpu::kConstantAnyHit, query == RayQuery::any ? 1u : 0u});
    return {context_, *layout_, kernels_.trace_rays, constants, "trace_rays"};
  }
  // New buffers; the one of the rays also stands where kernels of other kinds have theirs.
  void bind(std::size_t ray_bytes, std::size_t result_bytes) {
    constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    rays_ = vulkan::Buffer(context_, ray_bytes, kUsage, vulkan::Buffer::Memory::device, "rays");
    results_ = vulkan::Buffer(context_, result_bytes, kUsage, vulkan::Buffer::Memory::device, "hits");
    for (const vulkan::Binding& b : layout_->bindings()) {
      if (b.type == VK_DESCRIPTOR_TYPE_STORAGE_BUFFER) set_->bind(b.number, rays_);
    }
    scene_->bind(*set_);
    set_->bind(gpu::kBindingResults, results_);
  }

  KernelSet kernels_;
  Placement placement_;
  vulkan::Context context_;
  vulkan::Commands commands_;
  std::optional<vulkan::BindingLayout> layout_;
  std::unique_ptr<DeviceScene> scene_;
  std::vector<vulkan::Specialization> constants_;
  vulkan::Kernel closest_, any_;
  vulkan::Buffer rays_, results_;
  std::optional<vulkan::BindingSet> set_;
  std::size_t capacity_ = 0;
  std::uint32_t count_ = 0;
};

}  // namespace

std::unique_ptr<RayCaster> make_gpu_ray_caster(const Scene& scene, const GpuOptions& options) {
  return std::make_unique<GpuRayCaster>(scene, options);
}

}  // namespace etendue
