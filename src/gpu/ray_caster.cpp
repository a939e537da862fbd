#include "gpu/ray_caster.h"

#include <algorithm>

#include <fmt/core.h>

#include "core/errors.h"
#include "gpu/device_scene.h"
#include "gpu/kernel_set.h"

namespace etendue {
namespace {

static_assert(sizeof(CastRay) == sizeof(gpu::RayRequest) && sizeof(CastHit) == sizeof(gpu::RayResult));
static_assert(CastHit::kNone == gpu::kNone);

constexpr std::size_t kMostRays = std::size_t{1} << 22;
constexpr double kCastTimeout = 60.0;  // seconds
// Step budget of one ray. lavapipe silently ends loops after 65 535 iterations of a group of 8 lanes, whose walks may
// run one after the other; a walk through a tree of 64 levels ends long before that.
constexpr std::uint32_t kMostSteps = 7500;

class GpuRayCaster final : public RayCaster {
 public:
  GpuRayCaster(const SharedScene& scene, const GpuOptions& options) : device_(open_device(options)) {
    const auto compiled = scene.once<CompiledScene>(compile_scene);
    placement_ = {compiled->normalization.center, compiled->normalization.scale};
    scene_ = std::make_unique<DeviceScene>(device_, compiled, options.wanted_loads(), std::span<const DeviceNeed>{},
                                           DeviceScene::Layouts{}, options.queries());
    kernels_ = kernel_set(options, scene_->loads());
    set_.emplace(*device_->context, scene_->request_kernels().set);
    constants_ = scene_->constants();
    constants_.insert(constants_.end(), kernels_.constants.begin(), kernels_.constants.end());
    closest_ = make_kernel(RayQuery::closest);
    any_ = make_kernel(RayQuery::any);
    bind(16, 16);
  }

  std::string device_name() const override { return device_->context->info().name; }
  std::string driver_name() const override { return device_->context->info().driver; }
  Placement placement() const override { return placement_; }
  std::size_t max_rays() const override {
    const std::size_t per_binding = device_->context->limits().maxStorageBufferRange / sizeof(CastRay);
    const std::size_t per_dispatch =
        std::size_t{device_->context->limits().maxComputeWorkGroupCount[0]} * gpu::kWorkgroupSize;
    return std::min({kMostRays, per_binding, per_dispatch});
  }
  std::size_t enough_rays() const override {
    return std::min(max_rays(), device_->context->is_cpu() ? std::size_t{1} << 19 : kMostRays);
  }

  void load(std::span<const CastRay> rays) override {
    if (rays.size() > max_rays())
      throw Error(ErrorKind::usage, fmt::format("{} rays at a time are more than the {} that '{}' takes.", rays.size(),
                                                max_rays(), device_->context->info().name));
    if (rays.size() > capacity_) {
      capacity_ = rays.size();
      bind(capacity_ * sizeof(CastRay), capacity_ * sizeof(CastHit));
    }
    device_->commands.upload(rays_, 0, std::as_bytes(rays));
    count_ = static_cast<std::uint32_t>(rays.size());
  }

  double cast(RayQuery query) override {
    if (count_ == 0) return 0.0;
    gpu::Pass pass{};
    pass.request_count = count_;
    pass.step_budget = kMostSteps;
    const vulkan::Kernel& kernel = query == RayQuery::any ? any_ : closest_;
    return device_->commands.dispatch(scene_->request_kernels().pipeline, kernel, {&scene_->set(), &*set_},
                                      std::as_bytes(std::span(&pass, 1)),
                                      (count_ + gpu::kWorkgroupSize - 1) / gpu::kWorkgroupSize, kCastTimeout);
  }

  std::vector<CastHit> hits() override {
    std::vector<CastHit> hits(count_);
    device_->commands.download(results_, 0, std::as_writable_bytes(std::span(hits)));
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (hits[i].steps <= kMostSteps) continue;
      throw Error(ErrorKind::scene,
                  fmt::format("Ray {} takes more than {} steps through the tree, the most a ray may take here: "
                              "thousands of surfaces overlap where it passes; thin them out.",
                              i, kMostSteps));
    }
    return hits;
  }

 private:
  vulkan::Kernel make_kernel(RayQuery query) {
    std::vector<vulkan::Specialization> constants = constants_;
    constants.push_back({gpu::kConstantAnyHit, query == RayQuery::any ? 1u : 0u});
    return {*device_->context, scene_->request_kernels().pipeline, kernels_.trace_rays, constants, "trace_rays"};
  }
  void bind(std::size_t ray_bytes, std::size_t result_bytes) {
    constexpr VkBufferUsageFlags kUsage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    rays_ = vulkan::Buffer(*device_->context, ray_bytes, kUsage, vulkan::Buffer::Memory::device, "rays");
    results_ = vulkan::Buffer(*device_->context, result_bytes, kUsage, vulkan::Buffer::Memory::device, "hits");
    set_->bind(gpu::kBindingRequests, rays_);
    set_->bind(gpu::kBindingResults, results_);
  }

  KernelSet kernels_;
  Placement placement_;
  std::shared_ptr<GpuDevice> device_;
  std::unique_ptr<DeviceScene> scene_;
  std::vector<vulkan::Specialization> constants_;
  vulkan::Kernel closest_, any_;
  vulkan::Buffer rays_, results_;
  std::optional<vulkan::BindingSet> set_;
  std::size_t capacity_ = 0;
  std::uint32_t count_ = 0;
};

}  // namespace

std::unique_ptr<RayCaster> make_gpu_ray_caster(const SharedScene& scene, const GpuOptions& options) {
  return std::make_unique<GpuRayCaster>(scene, options);
}

}  // namespace etendue
