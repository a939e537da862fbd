#include <algorithm>
#include <cmath>

#include "reference/frame.h"
#include "reference/integrator.h"
#include "reference/texture.h"

namespace etendue::reference {
namespace {

/// Power heuristic with exponent 2 for a strategy of density `own` against one of density `other` [Veach1997, §9.2].
double power_heuristic(double own, double other) {
  const double ratio = other / own;
  return 1.0 / (1.0 + ratio * ratio);
}

/// A material at a point of the surface, in world space. The shading normal alone decides which side a direction is on.
class Scatterer {
 public:
  Scatterer(const Bsdf& bsdf, const Surface& surface, const Vec3& wo)
      : bsdf_(bsdf), frame_(surface.ns), wo_(frame_.to_local(wo)) {}

  /// The normal by which lights are chosen; 0 where light from both sides counts.
  Vec3 light_normal(const Vec3& ns) const { return traits(bsdf_).transmissive ? Vec3(0.0) : ns; }
  /// Nothing scatters toward `wo`.
  bool black() const { return is_one_sided(bsdf_) && wo_.z <= 0.0; }

  Vec3 eval(const Vec3& wi) const { return reference::eval(bsdf_, wo_, frame_.to_local(wi)); }
  double pdf(const Vec3& wi) const { return reference::pdf(bsdf_, wo_, frame_.to_local(wi)); }
  /// Like that of bsdf.h, with `wi` in world space; lobe `none` unless its weight is positive somewhere.
  BsdfSample sample(const SampleRandom::Material& random) const {
    BsdfSample sample = reference::sample(bsdf_, wo_, random.lobe, {random.u, random.v});
    if (sample.lobe == Lobe::none || is_zero(sample.weight)) return {};
    sample.wi = frame_.to_world(sample.wi);
    return sample;
  }

 private:
  const Bsdf& bsdf_;  // its parameters are constants
  Frame frame_;
  Vec3 wo_;
};

/// The chance of a path of `whitted` to go on behind a mirror or glass.
constexpr double kWhittedSurvival = 0.95;

/// One path from the camera; the steps are those of docs/conventions.md, "Path estimator".
class Path {
 public:
  Path(const World& world, const SampleRandom& random, DecisionLog& log)
      : world_(world),
        integrator_(world.scene().integrator),
        samples_lights_(samples_lights(integrator_)),
        weighs_(weighs_strategies(integrator_)),
        random_(random),
        log_(log) {}

  Vec3 trace(Ray ray) {
    const bool path = integrator_.type == Integrator::Type::path;
    max_depth_ = path ? integrator_.max_depth : Integrator::kUnlimitedDepth;
    std::optional<Surface> hit = first_visible(ray);
    for (std::uint32_t depth = 1; depth <= max_depth_; ++depth) {
      if (depth > 1) {
        hit = world_.closest_hit(ray);
        log_.segment(hit);
      }
      const bool goes_on = hit ? scatter(*hit, depth, ray) : leave(ray, depth == 1);
      log_.radiance(radiance_);
      if (!goes_on) break;
    }
    return radiance_;
  }

  /// Integrator `direct`: rounds of one light sample and one material sample at the first surface, each divided by how
  /// many of its kind there are.
  Vec3 trace_direct(const Ray& camera_ray) {
    const std::uint32_t rounds = std::max(integrator_.emitter_samples, integrator_.bsdf_samples);
    for (std::uint32_t round = 0; round < rounds; ++round) {
      Ray ray = camera_ray;
      beta_ = Vec3(1.0);
      previous_.reset();
      const std::optional<Surface> hit = first_visible(ray);
      if (!hit && round == 0) leave(ray, true);
      const bool bounced = hit && direct_round(*hit, round, ray);
      log_.radiance(radiance_);
      if (!hit || black_) break;
      if (!bounced) continue;
      const std::optional<Surface> end = world_.closest_hit(ray);
      log_.segment(end);
      if (end) {
        radiance_ += beta_ * emission(*end, -ray.direction);
      } else {
        leave(ray, false);
      }
      log_.radiance(radiance_);
    }
    return radiance_;
  }

 private:
  bool leave(const Ray& ray, bool seen_by_camera) {
    if (!(seen_by_camera && integrator_.hide_emitters)) radiance_ += beta_ * from_outside(ray.direction);
    return false;
  }

  /// The first surface along a camera ray that is not hidden from it; `ray` then is the part that reaches it.
  std::optional<Surface> first_visible(Ray& ray) {
    for (;;) {
      const std::optional<Surface> hit = world_.closest_hit(ray);
      log_.segment(hit);
      if (!hit || !integrator_.hide_emitters) return hit;
      const AreaEmitter* emitter = world_.scene().emitter_of(world_.scene().instances[hit->instance]);
      if (emitter == nullptr || is_zero(emitter->radiance.value)) return hit;
      log_.radiance(radiance_);
      const double passed = glm::dot(hit->p - ray.origin, ray.direction);
      ray = {.origin = hit->offset_toward(ray.direction), .direction = ray.direction, .t_max = ray.t_max - passed};
    }
  }

  /// The first segment of a round; true when `ray` has become that of a material sample.
  bool direct_round(const Surface& surface, std::uint32_t round, Ray& ray) {
    const Instance& instance = world_.scene().instances[surface.instance];
    const Bsdf bsdf = at_point(world_.scene(), world_.scene().bsdf_of(instance), surface);
    const Vec3 wo = -ray.direction;
    if (round == 0) radiance_ += beta_ * emission(surface, wo);
    const Scatterer scatterer(bsdf, surface, wo);
    black_ = scatterer.black();
    if (black_) {
      log_.lobe(Lobe::none);
      return false;
    }
    // Numbers are counted by segments, of which a round has two.
    const std::uint32_t k = 2 * round;
    const bool delta = is_delta(bsdf);
    if (round < integrator_.emitter_samples && !delta) add_sampled_light(surface, scatterer, k);
    if (round >= integrator_.bsdf_samples) return false;
    const BsdfSample bounce = scatterer.sample(random_.material(k));
    log_.lobe(bounce.lobe);
    if (bounce.lobe == Lobe::none) return false;
    beta_ *= bounce.weight / static_cast<double>(integrator_.bsdf_samples);
    previous_ = Previous{.point = surface.p,
                         .ns = scatterer.light_normal(surface.ns),
                         .pdf_w = bounce.pdf,
                         .delta = is_delta(bounce.lobe)};
    ray = {.origin = surface.offset_toward(bounce.wi), .direction = bounce.wi};
    return true;
  }

  /// Light that arrives from outside, times the share that finding it by chance has in the estimate.
  Vec3 from_outside(const Vec3& w) const {
    const Environment& environment = world_.environment();
    const Vec3 L = environment.radiance(w);
    if (is_zero(L) || !found_by_sampling()) return L;
    if (!weighs_) return Vec3(0.0);
    return L * power_heuristic(bsdf_count() * previous_->pdf_w, light_count() * environment.pdf_w(w));
  }

  /// Whether the vertex before has sampled lights, too.
  bool found_by_sampling() const { return samples_lights_ && previous_ && !previous_->delta; }

  /// Gathers light at vertex `depth` − 1 and turns `ray` into the next segment; false when the path ends.
  bool scatter(const Surface& surface, std::uint32_t depth, Ray& ray) {
    const Instance& instance = world_.scene().instances[surface.instance];
    const Bsdf bsdf = at_point(world_.scene(), world_.scene().bsdf_of(instance), surface);
    const Vec3 wo = -ray.direction;
    radiance_ += beta_ * emission(surface, wo);
    if (depth == max_depth_) return false;
    const Scatterer scatterer(bsdf, surface, wo);
    if (scatterer.black()) {
      log_.lobe(Lobe::none);
      return false;
    }
    const std::uint32_t k = depth - 1;
    if (samples_lights_ && !is_delta(bsdf)) add_sampled_light(surface, scatterer, k);
    if (integrator_.type == Integrator::Type::whitted && !is_delta(bsdf)) return false;

    const SampleRandom::Material random = random_.material(k);
    const BsdfSample bounce = scatterer.sample(random);
    log_.lobe(bounce.lobe);
    if (bounce.lobe == Lobe::none) return false;
    beta_ *= bounce.weight;
    eta_scale_ *= bounce.eta * bounce.eta;
    if (!survives(depth, random.roulette)) return false;

    previous_ = Previous{.point = surface.p,
                         .ns = scatterer.light_normal(surface.ns),
                         .pdf_w = bounce.pdf,
                         .delta = is_delta(bounce.lobe)};
    ray = {.origin = surface.offset_toward(bounce.wi), .direction = bounce.wi};
    return true;
  }

  /// Radiance emitted toward `wo`, times the share that finding it by chance has in the estimate.
  Vec3 emission(const Surface& surface, const Vec3& wo) const {
    const Vec3 Le = emitted_radiance(world_.scene(), surface, wo);
    if (is_zero(Le) || !found_by_sampling()) return Le;
    if (!weighs_) return Vec3(0.0);
    const double pdf_light = world_.environment().lights_prob() *
                             world_.lights().pdf_w_mis(world_.scene(), previous_->point, previous_->ns, surface);
    const double w_bsdf = power_heuristic(bsdf_count() * previous_->pdf_w, light_count() * pdf_light);
    return Le * w_bsdf;
  }

  /// Light of points has no bound; nearer than the film can tell, this is one.
  void add_sampled_light(const Surface& surface, const Scatterer& scatterer, std::uint32_t k) {
    bool delta = false;
    const Vec3 added = beta_ * sampled_light(surface, scatterer, k, delta);
    radiance_ += delta ? glm::min(added, Vec3(world_.delta_light_limit())) : added;
  }

  /// Next-event estimation at vertex `k`: reflected radiance due to a direction of the environment or a point of a
  /// light.
  Vec3 sampled_light(const Surface& surface, const Scatterer& scatterer, std::uint32_t k, bool& delta) const {
    const Environment& environment = world_.environment();
    if (environment.is_sampled()) {
      if (const auto sample = environment.sample(random_.environment(k)))
        return outside_light(surface, scatterer, *sample, delta);
    }
    if (world_.lights().empty()) return Vec3(0.0);
    return direct_light(surface, scatterer, random_.light(k), delta) / environment.lights_prob();
  }

  Vec3 outside_light(const Surface& surface, const Scatterer& scatterer, const EnvironmentSample& sample,
                     bool& delta) const {
    delta = sample.delta;
    const Vec3 unshadowed = scatterer.eval(sample.wi) * sample.radiance;
    const bool contributes = !is_zero(unshadowed) && world_.escapes(surface.offset_toward(sample.wi), sample.wi);
    log_.environment(sample, contributes);
    if (!contributes) return Vec3(0.0);
    const bool shared = weighs_ && !delta;
    const double w_light =
        shared ? power_heuristic(light_count() * sample.pdf_w, bsdf_count() * scatterer.pdf(sample.wi)) : 1.0;
    return unshadowed / sample.pdf_w * w_light / light_count();
  }

  /// Reflected radiance due to one sampled point of one light, where no other than those is chosen.
  Vec3 direct_light(const Surface& surface, const Scatterer& scatterer, const SampleRandom::Light& random,
                    bool& delta) const {
    const std::optional<LightSample> chosen =
        world_.lights().sample(world_.scene(), surface.p, scatterer.light_normal(surface.ns), random);
    if (!chosen) return Vec3(0.0);
    const LightSample& light = *chosen;
    delta = light.delta;
    const Vec3 f = light.pdf_w > 0.0 ? scatterer.eval(light.wi) : Vec3(0.0);
    const Vec3 unshadowed = f * light.radiance;
    const bool contributes = !is_zero(unshadowed) &&
                             !world_.occluded(surface.offset_toward(light.wi), light.surface.offset_toward(-light.wi));
    log_.light(light, contributes);
    if (!contributes) return Vec3(0.0);
    const double pdf_mis = light.pdf_w_mis * world_.environment().lights_prob();
    const bool shared = weighs_ && !delta;  // with the strategy that meets lights by chance
    const double w_light =
        shared ? power_heuristic(light_count() * pdf_mis, bsdf_count() * scatterer.pdf(light.wi)) : 1.0;
    return unshadowed / light.pdf_w * w_light / light_count();
  }

  /// Russian roulette. Paths inside a medium carry radiance scaled by its squared index; `eta_scale_` undoes this, so
  /// that a path's chance does not depend on the medium it is in.
  bool survives(std::uint32_t depth, double u) {
    const bool whitted = integrator_.type == Integrator::Type::whitted;
    if (!whitted && (integrator_.rr_depth == 0 || depth < integrator_.rr_depth)) return true;
    const double q = whitted ? kWhittedSurvival : std::min(max_component(beta_) * eta_scale_, 0.99);
    const bool survived = u < q;
    log_.roulette(survived);
    if (survived) beta_ /= q;
    return survived;
  }

  /// Samples of a strategy that share a vertex; one but for `direct`.
  double light_count() const {
    return integrator_.type == Integrator::Type::direct ? integrator_.emitter_samples : 1.0;
  }
  double bsdf_count() const { return integrator_.type == Integrator::Type::direct ? integrator_.bsdf_samples : 1.0; }

  struct Previous {
    Vec3 point{0.0}, ns{0.0};
    double pdf_w = 0.0;
    bool delta = false;
  };

  const World& world_;
  const Integrator& integrator_;
  const bool samples_lights_, weighs_;
  std::uint32_t max_depth_ = 1;
  bool black_ = false;  ///< the surface that the rounds of `direct` look at reflects nothing
  const SampleRandom& random_;
  DecisionLog& log_;
  Vec3 beta_{1.0};
  Vec3 radiance_{0.0};
  double eta_scale_ = 1.0;
  std::optional<Previous> previous_;  ///< the vertex before; none for the camera
};

}  // namespace

Vec3 path_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log) {
  return Path(world, random, log).trace(camera_ray);
}

Vec3 direct_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log) {
  return Path(world, random, log).trace_direct(camera_ray);
}

}  // namespace etendue::reference
