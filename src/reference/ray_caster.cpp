#include "reference/ray_caster.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "core/version.h"
#include "reference/world.h"

namespace etendue {
namespace {

using reference::Vec3;

constexpr std::uint64_t kRaysAtATime = 1024;  // rays a thread takes at a time

class ReferenceRayCaster final : public RayCaster {
 public:
  ReferenceRayCaster(const Scene& scene, const Placement& placement) : world_(scene), placement_(placement) {}

  std::string device_name() const override { return "reference"; }
  std::string driver_name() const override { return std::string("etendue ") + version(); }
  Placement placement() const override { return placement_; }
  std::size_t max_rays() const override { return std::numeric_limits<std::uint32_t>::max(); }
  std::size_t enough_rays() const override { return std::size_t{1} << 17; }

  void load(std::span<const CastRay> rays) override { rays_.assign(rays.begin(), rays.end()); }

  double cast(RayQuery query) override {
    hits_.resize(rays_.size());
    const auto start = std::chrono::steady_clock::now();
    parallel_for(rays_.size(), kRaysAtATime, [&](std::uint64_t begin, std::uint64_t end) {
      for (std::uint64_t i = begin; i < end; ++i)
        hits_[i] = query == RayQuery::any ? any_hit(rays_[i]) : closest_hit(rays_[i]);
    });
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  std::vector<CastHit> hits() override { return hits_; }

 private:
  reference::Ray world_ray(const CastRay& ray) const {
    return {.origin = Vec3(ray.o) / placement_.scale + placement_.center,
            .direction = glm::normalize(Vec3(ray.d)),
            .t_min = ray.t_min / placement_.scale,
            .t_max = ray.t_max / placement_.scale};
  }
  CastHit closest_hit(const CastRay& ray) const {
    const reference::Ray world = world_ray(ray);
    const auto surface = world_.closest_hit(world);
    if (!surface) return {.t = ray.t_max};
    return {.t = static_cast<float>(glm::dot(surface->p - world.origin, world.direction) * placement_.scale),
            .instance = surface->instance,
            .primitive = surface->primitive};
  }
  CastHit any_hit(const CastRay& ray) const {
    if (!std::isfinite(ray.t_max)) return closest_hit(ray);
    const reference::Ray world = world_ray(ray);
    const bool hit =
        world_.occluded(world.origin + world.t_min * world.direction, world.origin + world.t_max * world.direction);
    return {.t = ray.t_max, .instance = hit ? 0 : CastHit::kNone};
  }

  reference::World world_;
  Placement placement_;
  std::vector<CastRay> rays_;
  std::vector<CastHit> hits_;
};

}  // namespace

std::unique_ptr<RayCaster> make_reference_ray_caster(const Scene& scene, const Placement& placement) {
  return std::make_unique<ReferenceRayCaster>(scene, placement);
}

}  // namespace etendue
