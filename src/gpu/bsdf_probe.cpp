#include "gpu/bsdf_probe.h"

#include <algorithm>

#include "gpu/device_scene.h"
#include "gpu/kernel_set.h"

namespace etendue {
namespace {

constexpr std::size_t kProbesAtATime = 1u << 18;  // samples or queries of one dispatch
constexpr double kProbeTimeout = 60.0;            // seconds

// A scene that contains only the material, so that it reaches the device in the same way as every material.
CompiledScene compile_material(const Bsdf& bsdf) {
  Scene scene;
  scene.add(Sphere{}, bsdf).name = "sphere";
  return compile_scene(scene);
}

std::vector<vulkan::Specialization> joined(std::vector<vulkan::Specialization> a,
                                           const std::vector<vulkan::Specialization>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class GpuBsdfProbe final : public BsdfProbe {
 public:
  GpuBsdfProbe(const Bsdf& bsdf, const GpuOptions& options)
      : kernels_(kernel_set(options, TableLoads::texel_buffer)),
        scene_(open_device(options), std::make_shared<const CompiledScene>(compile_material(bsdf)),
               TableLoads::texel_buffer),
        kernel_(context(), scene_.request_kernels().pipeline, kernels_.bsdf_samples,
                joined(scene_.constants(), kernels_.constants), "bsdf_samples"),
        queries_(context(), kProbesAtATime * sizeof(gpu::vec4), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                 vulkan::Buffer::Memory::device, "directions"),
        results_(context(), kProbesAtATime * sizeof(gpu::BsdfProbeResult), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                 vulkan::Buffer::Memory::device, "material samples"),
        set_(context(), scene_.request_kernels().set) {
    set_.bind(gpu::kBindingRequests, queries_);
    set_.bind(gpu::kBindingResults, results_);
  }

  std::string device_name() const override { return context().info().name; }
  std::string driver_name() const override { return context().info().driver; }

  std::vector<BsdfDraw> sample(const glm::dvec3& wo, std::uint32_t seed, std::uint32_t first,
                               std::uint32_t count) override {
    std::vector<BsdfDraw> draws;
    draws.reserve(count);
    for (std::uint32_t done = 0; done < count; done += kProbesAtATime) {
      const auto n = static_cast<std::uint32_t>(std::min<std::size_t>(kProbesAtATime, count - done));
      for (const gpu::BsdfProbeResult& r : run({wo, seed, first + done, n, 0, 0})) {
        draws.push_back({r.wi, r.pdf, r.weight, static_cast<ProbeLobe>(r.lobe)});
      }
    }
    return draws;
  }

  std::vector<BsdfValue> evaluate(const glm::dvec3& wo, std::span<const glm::dvec3> wi) override {
    std::vector<BsdfValue> values;
    values.reserve(wi.size());
    for (std::size_t done = 0; done < wi.size(); done += kProbesAtATime) {
      const auto chunk = wi.subspan(done, std::min(kProbesAtATime, wi.size() - done));
      std::vector<gpu::vec4> directions;
      for (const glm::dvec3& w : chunk) directions.emplace_back(w, 0.0);
      commands().upload(queries_, 0, std::as_bytes(std::span(directions)));
      for (const gpu::BsdfProbeResult& r : run({wo, 0, 0, static_cast<std::uint32_t>(chunk.size()), 1, 0})) {
        values.push_back({r.weight, r.pdf});
      }
    }
    return values;
  }

 private:
  const vulkan::Context& context() const { return *scene_.device().context; }
  vulkan::Commands& commands() { return scene_.device().commands; }
  std::vector<gpu::BsdfProbeResult> run(const gpu::BsdfProbePass& pass) {
    const std::uint32_t groups = (pass.count + gpu::kWorkgroupSize - 1) / gpu::kWorkgroupSize;
    commands().dispatch(scene_.request_kernels().pipeline, kernel_, {&scene_.set(), &set_},
                        std::as_bytes(std::span(&pass, 1)), groups, kProbeTimeout);
    std::vector<gpu::BsdfProbeResult> results(pass.count);
    commands().download(results_, 0, std::as_writable_bytes(std::span(results)));
    return results;
  }

  KernelSet kernels_;
  DeviceScene scene_;
  vulkan::Kernel kernel_;
  vulkan::Buffer queries_, results_;
  vulkan::BindingSet set_;
};

}  // namespace

std::unique_ptr<BsdfProbe> make_gpu_bsdf_probe(const Bsdf& bsdf, const GpuOptions& options) {
  return std::make_unique<GpuBsdfProbe>(bsdf, options);
}

}  // namespace etendue
