#include "gpu/bsdf_probe.h"

#include <algorithm>
#include <bit>

#include "gpu/device_scene.h"
#include "gpu/device_view.h"
#include "gpu/kernel_set.h"

namespace etendue {
namespace {

constexpr std::size_t kProbesAtATime = 1u << 18;  // samples or queries of one dispatch
constexpr double kProbeTimeout = 60.0;            // seconds

std::vector<vulkan::Specialization> joined(std::vector<vulkan::Specialization> a,
                                           const std::vector<vulkan::Specialization>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class GpuBsdfProbe final : public BsdfProbe {
 public:
  GpuBsdfProbe(const Scene& patch, const GpuOptions& options)
      : kernels_(kernel_set(options, TableLoads::texel_buffer)),
        scene_(open_device(options), std::make_shared<const CompiledScene>(compile_scene(patch)),
               TableLoads::texel_buffer),
        view_(scene_.device()),
        kernel_(context(), scene_.request_kernels().pipeline, kernels_.bsdf_samples,
                joined(scene_.constants(), kernels_.constants), "bsdf_samples"),
        queries_(context(), kProbesAtATime * sizeof(gpu::vec4), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                 vulkan::Buffer::Memory::device, "directions"),
        results_(context(), kProbesAtATime * sizeof(gpu::BsdfProbeResult), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                 vulkan::Buffer::Memory::device, "material samples"),
        set_(context(), scene_.request_kernels().set) {
    view_.set(scene_.device(), compile_view(scene_.facts(), view_of(patch), 0));
    view_.bind(set_);
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
      for (const gpu::BsdfProbeResult& r : run({wo, seed, first + done, n, gpu::kProbeSamples, 0})) {
        draws.push_back({r.wi, r.pdf, r.weight, static_cast<ProbeLobe>(r.lobe)});
      }
    }
    return draws;
  }

  std::vector<BsdfValue> evaluate(const glm::dvec3& wo, std::uint32_t seed, std::span<const BsdfQuery> queries,
                                  Part part) override {
    std::vector<BsdfValue> values;
    values.reserve(queries.size());
    for (std::size_t done = 0; done < queries.size(); done += kProbesAtATime) {
      const auto chunk = queries.subspan(done, std::min(kProbesAtATime, queries.size() - done));
      std::vector<gpu::vec4> directions;
      for (const BsdfQuery& q : chunk) directions.emplace_back(q.wi, std::bit_cast<float>(q.sample));
      commands().upload(queries_, 0, std::as_bytes(std::span(directions)));
      const gpu::uint mode = part == Part::mixture ? gpu::kProbeMixed : gpu::kProbeChosen;
      for (const gpu::BsdfProbeResult& r : run({wo, seed, 0, static_cast<std::uint32_t>(chunk.size()), mode, 0})) {
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
  DeviceView view_;
  vulkan::Kernel kernel_;
  vulkan::Buffer queries_, results_;
  vulkan::BindingSet set_;
};

}  // namespace

std::unique_ptr<BsdfProbe> make_gpu_bsdf_probe(const Scene& patch, const GpuOptions& options) {
  return std::make_unique<GpuBsdfProbe>(patch, options);
}

}  // namespace etendue
