#include "bench/ray_check.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace etendue {
namespace {

// Beyond this two distances are another hit. Single precision loses a few 1e-7 of the scene's size, more by the inverse
// cosine where a ray grazes a surface.
constexpr double kSameDistance = 1e-4;   // relative
constexpr double kShortDistance = 0.01;  // normalised; shorter distances count like this one
// Rays beside a doubtful one: so many, at most so far away, in normalised coordinates and in direction. A coordinate
// near 1 has units of 2^-24, a rotation into the frame of a ray loses a few of them.
constexpr std::size_t kBeside = 48;
constexpr float kNudge = 0x1p-20f;

double distance_error(double found, double expected) {
  return std::abs(found - expected) / std::max(expected, kShortDistance);
}

bool is_hit(const CastHit& hit) {
  return hit.instance != CastHit::kNone;
}

bool same(const CastHit& found, const CastHit& expected, RayQuery query) {
  if (is_hit(found) != is_hit(expected)) return false;
  return !is_hit(found) || query == RayQuery::any || distance_error(found.t, expected.t) <= kSameDistance;
}

std::vector<CastRay> rays_beside(const CastRay& ray, std::mt19937& engine) {
  const float reach = 1.0f + std::max({std::abs(ray.o.x), std::abs(ray.o.y), std::abs(ray.o.z)});
  const auto nudge = [&] {
    const auto component = [&] { return kNudge * (static_cast<float>(engine() >> 8) * 0x1p-23f - 1.0f); };
    return glm::vec3(component(), component(), component());
  };
  std::vector<CastRay> rays(kBeside, ray);
  for (CastRay& r : rays) {
    r.o += reach * nudge();
    r.d += nudge();
  }
  return rays;
}

// Whether the hits of the neighbouring rays include `found`, or lie on both sides of it.
bool explains(std::span<const CastHit> beside, const CastHit& found, RayQuery query) {
  bool nearer = false, farther = false;
  for (const CastHit& b : beside) {
    if (same(found, b, query)) return true;
    nearer = nearer || (is_hit(b) && b.t < found.t);
    farther = farther || !is_hit(b) || b.t > found.t;
  }
  return is_hit(found) && nearer && farther;
}

}  // namespace

RayCheck check_rays(const RaySet& set, const std::vector<CastHit>& hits, RayCaster& reference, std::size_t most) {
  const std::size_t stride = std::max<std::size_t>(1, (set.rays.size() + most - 1) / std::max<std::size_t>(1, most));
  std::vector<CastRay> rays;
  for (std::size_t i = 0; i < set.rays.size(); i += stride) rays.push_back(set.rays[i]);
  reference.load(rays);
  reference.cast(set.query);
  const std::vector<CastHit> expected = reference.hits();
  RayCheck check{.checked = rays.size()};
  std::vector<CastRay> beside;
  std::vector<CastHit> doubtful;
  std::mt19937 engine(1);
  for (std::size_t k = 0; k < rays.size(); ++k) {
    const CastHit& found = hits[k * stride];
    check.hits += is_hit(found);
    if (!same(found, expected[k], set.query)) {
      doubtful.push_back(found);
      for (const CastRay& ray : rays_beside(rays[k], engine)) beside.push_back(ray);
    } else if (is_hit(found) && set.query == RayQuery::closest) {
      check.largest_error = std::max(check.largest_error, distance_error(found.t, expected[k].t));
    }
  }
  check.differ = doubtful.size();
  reference.load(beside);
  reference.cast(set.query);
  const std::vector<CastHit> answers = reference.hits();
  for (std::size_t k = 0; k < doubtful.size(); ++k) {
    check.wrong += !explains(std::span(answers).subspan(k * kBeside, kBeside), doubtful[k], set.query);
  }
  return check;
}

}  // namespace etendue
