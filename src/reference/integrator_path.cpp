#include <algorithm>
#include <cmath>

#include "reference/adapters.h"
#include "reference/integrator.h"
#include "reference/scatterer.h"
#include "reference/texture.h"
#include "reference/walk.h"
#include "scene/materials.h"

namespace etendue::reference {
namespace {

/// Power heuristic with exponent 2 for a strategy of density `own` against one of density `other` [Veach1997, §9.2].
double power_heuristic(double own, double other) {
  const double ratio = other / own;
  return 1.0 / (1.0 + ratio * ratio);
}

/// The fraction of light left after a distance in an absorbing medium; 0 for infinite distances.
Vec3 transmittance(const Vec3& absorption, double distance) {
  Vec3 passed(1.0);
  for (int c = 0; c < 3; ++c) {
    if (absorption[c] != 0.0) passed[c] = std::exp(-absorption[c] * distance);
  }
  return passed;
}

/// The survival probability of a path of `whitted` after a mirror or glass.
constexpr double kWhittedSurvival = 0.95;

/// One path from the camera; the steps are those of docs/conventions.md, "Path estimator".
class Path {
 public:
  Path(const World& world, const SampleRandom& random, DecisionLog& log)
      : world_(world),
        integrator_(world.scene().integrator),
        samples_lights_(samples_lights(integrator_)),
        weighs_(weighs_strategies(integrator_)),
        counts_passes_(counts_passes(integrator_)),
        random_(random),
        log_(log) {}

  Vec3 trace(Ray ray) {
    const bool path = integrator_.type == Integrator::Type::path;
    max_depth_ = path ? integrator_.max_depth : Integrator::kUnlimitedDepth;
    for (std::uint32_t depth = 1; depth <= max_depth_;) {
      const std::optional<Surface> hit = next_surface(ray, depth == 1);
      const Step step = hit ? scatter(*hit, depth, ray) : leave(ray, depth == 1);
      log_.radiance(radiance_);
      if (step == Step::ends) break;
      if (step == Step::scatters || counts_passes_) ++depth;
    }
    return radiance_;
  }

  /// Integrator `direct`: rounds of one light sample and one material sample at the first surface, each divided by the
  /// number of samples of its kind.
  Vec3 trace_direct(const Ray& camera_ray) {
    const std::uint32_t rounds = std::max(integrator_.emitter_samples, integrator_.bsdf_samples);
    for (std::uint32_t round = 0; round < rounds; ++round) {
      Ray ray = camera_ray;
      beta_ = Vec3(1.0);
      absorption_ = Vec3(0.0);
      color_.reset();
      previous_.reset();
      bounces_ = 0;
      std::optional<Surface> hit;
      Step step = Step::passes;
      while (step == Step::passes) {
        hit = next_surface(ray, true);
        if (!hit && round == 0) leave(ray, true);
        step = hit ? direct_round(*hit, round, ray) : Step::ends;
        log_.radiance(radiance_);
      }
      if (!hit || black_) break;
      if (step == Step::scatters) end_direct_round(ray, 2 * round + 1);
    }
    return radiance_;
  }

 private:
  /// What happens to a path at a surface: it ends, continues in another direction, or passes the surface.
  enum class Step { ends, scatters, passes };

  Step leave(const Ray& ray, bool seen_by_camera) {
    const bool hidden = (seen_by_camera && integrator_.hide_emitters) || (bounces_ == 0 && integrator_.hide_background);
    if (!hidden) gather(bounces_, beta_ * from_outside(ray.direction));
    return Step::ends;
  }

  std::optional<Surface> next_surface(Ray& ray, bool from_camera) {
    if (from_camera) return first_visible(world_, ray, radiance_, log_);
    const std::optional<Surface> hit = world_.closest_hit(ray);
    log_.segment(ray, hit);
    beta_ *= transmittance(absorption_, (hit ? hit->t : INFINITY) - ray.t_min);
    return hit;
  }

  /// Adds light that was scattered so many times, if the integrator gathers that part.
  void gather(std::uint32_t bounces, const Vec3& light) {
    using enum Integrator::LightPart;
    const bool direct_light = bounces <= 1;
    if (integrator_.light_part == all || direct_light == (integrator_.light_part == direct)) radiance_ += light;
  }

  /// The second segment of a round: gathers the light that it hits by chance.
  void end_direct_round(Ray ray, std::uint32_t vertex) {
    for (;;) {
      const std::optional<Surface> end = next_surface(ray, false);
      if (end) {
        gather(bounces_, beta_ * emission(*end, -ray.direction));
      } else {
        leave(ray, false);
      }
      const bool passes = end && !scatterer_at(*end, ray.direction, vertex);
      if (passes) pass(*end, ray);
      log_.radiance(radiance_);
      if (!passes) return;
    }
  }

  /// The scatterer at vertex `k` for a ray in the direction `w`, or nothing if the ray passes the surface.
  std::optional<Mixture> scatterer_at(const Surface& surface, const Vec3& w, std::uint32_t k) {
    const Scene& scene = world_.scene();
    const std::optional<ChosenMaterials> found = choose_materials(scene, surface, w, random_, k);
    if (!found) return std::nullopt;
    const auto scatterer = [&](const ChosenMaterial& m, bool disperses) {
      Bsdf bsdf = material_at(scene, m, surface, w);
      return Scatterer(disperses ? dispersed(std::move(bsdf), surface, w, k) : std::move(bsdf), m, -w);
    };
    const Scatterer chosen = scatterer(found->chosen, true);
    if (!found->other) return Mixture(chosen);
    // The other half chooses a colour only if it is really mixed in.
    const Mixture mixture(chosen, found->share, scatterer(*found->other, false));
    return mixture.mixed() ? Mixture(chosen, found->share, scatterer(*found->other, true)) : mixture;
  }

  /// A dispersing material refracts each of the three colours differently, and from there on a path carries only one.
  Bsdf dispersed(Bsdf bsdf, const Surface& surface, const Vec3& w, std::uint32_t k) {
    auto* gltf = std::get_if<GltfBsdf>(&bsdf);
    if (gltf == nullptr || !disperses(*gltf)) return bsdf;
    if (!color_) {
      const SampleRandom::Decision decision{k, surface.instance, surface.primitive, glm::dot(w, surface.ng) > 0.0,
                                            false};
      color_ = std::min(2, static_cast<int>(3.0 * random_.choice(decision, UINT32_MAX)));
      for (int c = 0; c < 3; ++c) beta_[c] *= c == *color_ ? 3.0 : 0.0;
    }
    // n_F − n_C = (n − 1) / V, V = 20 / dispersion; the indices for red and blue are half of it below and above that
    // for green.
    const double n = std::max(1.001, gltf->ior.value), spread = (n - 1.0) * gltf->dispersion / 20.0;
    gltf->met.bending_index = std::max(1.001, n + (*color_ - 1) * spread / 2.0);
    return bsdf;
  }

  Step pass(const Surface& surface, Ray& ray) {
    log_.lobe(Lobe::passed);
    go_behind(surface, ray);
    return Step::passes;
  }

  /// Whether a shadow ray from vertex `k` hits nothing, or passes everything that it hits.
  bool unoccluded(Ray ray, std::uint32_t k) const {
    for (std::uint64_t segment = std::uint64_t{k} + 2; !counts_passes_ || segment <= max_depth_; ++segment) {
      const std::optional<Surface> hit = world_.closest_hit(ray);
      if (!hit) return true;
      if (choose_material(world_.scene(), *hit, ray.direction, random_, k, true)) return false;
      go_behind(*hit, ray);
    }
    return false;
  }

  /// The first segment of a round. If it scatters, `ray` becomes that of a material sample.
  Step direct_round(const Surface& surface, std::uint32_t round, Ray& ray) {
    if (round == 0) gather(bounces_, beta_ * emission(surface, -ray.direction));
    // Random numbers are indexed by segments, of which a round has two.
    const std::uint32_t k = 2 * round;
    const std::optional<Mixture> chosen = scatterer_at(surface, ray.direction, k);
    if (!chosen) return pass(surface, ray);
    const Mixture& scatterer = *chosen;
    black_ = scatterer.black();
    if (black_) {
      log_.lobe(Lobe::none);
      return Step::ends;
    }
    const bool delta = scatterer.delta();
    if (round < integrator_.emitter_samples && !delta) add_sampled_light(surface, scatterer, k);
    if (round >= integrator_.bsdf_samples) return Step::ends;
    const BsdfSample bounce = scatterer.sample(random_.material(k));
    log_.lobe(bounce.lobe);
    if (bounce.lobe == Lobe::none) return Step::ends;
    ++bounces_;
    beta_ *= bounce.weight / static_cast<double>(integrator_.bsdf_samples);
    absorption_ = scatterer.absorption_toward(bounce.wi, absorption_);
    previous_ = Previous{
        .point = surface.p, .ns = scatterer.light_normal(), .pdf_w = bounce.pdf, .delta = is_delta(bounce.lobe)};
    ray = {.origin = surface.offset_toward(bounce.wi), .direction = bounce.wi};
    return Step::scatters;
  }

  /// Light arriving from outside, times the MIS weight of finding it by chance.
  Vec3 from_outside(const Vec3& w) const {
    const Environment& environment = world_.environment();
    const Vec3 L = environment.radiance(w);
    if (is_zero(L) || !found_by_sampling()) return L;
    if (!weighs_) return Vec3(0.0);
    return L * power_heuristic(bsdf_count() * previous_->pdf_w, light_count() * environment.pdf_w(w));
  }

  /// Whether the previous vertex has sampled lights as well.
  bool found_by_sampling() const { return samples_lights_ && previous_ && !previous_->delta; }

  /// Gathers light at vertex `depth` − 1 and turns `ray` into the next segment.
  Step scatter(const Surface& surface, std::uint32_t depth, Ray& ray) {
    const bool last = depth == max_depth_;
    const std::uint32_t k = depth - 1;
    gather(bounces_, beta_ * emission(surface, -ray.direction));
    if (last && counts_passes_) return Step::ends;
    const std::optional<Mixture> chosen = scatterer_at(surface, ray.direction, k);
    if (!chosen) return pass(surface, ray);
    if (last || (integrator_.light_part == Integrator::LightPart::direct && bounces_ > 0)) return Step::ends;
    const Mixture& scatterer = *chosen;
    if (scatterer.black()) {
      log_.lobe(Lobe::none);
      return Step::ends;
    }
    if (samples_lights_ && !scatterer.delta()) add_sampled_light(surface, scatterer, k);
    if (integrator_.type == Integrator::Type::whitted && !scatterer.chosen().delta()) return Step::ends;

    const SampleRandom::Material random = random_.material(k);
    const BsdfSample bounce = scatterer.sample(random);
    log_.lobe(bounce.lobe);
    if (bounce.lobe == Lobe::none) return Step::ends;
    ++bounces_;
    beta_ *= bounce.weight;
    absorption_ = scatterer.absorption_toward(bounce.wi, absorption_);
    eta_scale_ *= bounce.eta * bounce.eta;
    if (!survives(depth, random.roulette)) return Step::ends;

    previous_ = Previous{
        .point = surface.p, .ns = scatterer.light_normal(), .pdf_w = bounce.pdf, .delta = is_delta(bounce.lobe)};
    ray = {.origin = surface.offset_toward(bounce.wi), .direction = bounce.wi};
    return Step::scatters;
  }

  /// Radiance emitted toward `wo`, times the MIS weight of finding it by chance.
  Vec3 emission(const Surface& surface, const Vec3& wo) const {
    const Vec3 Le = emitted_radiance(world_.scene(), surface, wo);
    if (is_zero(Le) || !found_by_sampling()) return Le;
    if (!weighs_) return Vec3(0.0);
    const double pdf_light = world_.environment().lights_prob() *
                             world_.lights().pdf_w_mis(world_.scene(), previous_->point, previous_->ns, surface);
    const double w_bsdf = power_heuristic(bsdf_count() * previous_->pdf_w, light_count() * pdf_light);
    return Le * w_bsdf;
  }

  /// The light of points is unbounded. This bound takes effect only at distances that single precision cannot resolve.
  void add_sampled_light(const Surface& surface, const Mixture& scatterer, std::uint32_t k) {
    bool delta = false;
    const Vec3 added = beta_ * sampled_light(surface, scatterer, k, delta);
    gather(bounces_ + 1, delta ? glm::min(added, Vec3(world_.delta_light_limit())) : added);
  }

  /// Next-event estimation at vertex `k`: the reflected radiance due to a direction of the environment or a point on a
  /// light.
  Vec3 sampled_light(const Surface& surface, const Mixture& scatterer, std::uint32_t k, bool& delta) const {
    const Environment& environment = world_.environment();
    if (environment.is_sampled()) {
      if (const auto sample = environment.sample(random_.environment(k)))
        return outside_light(surface, scatterer, *sample, k, delta);
    }
    if (world_.lights().empty()) return Vec3(0.0);
    return direct_light(surface, scatterer, k, delta) / environment.lights_prob();
  }

  Vec3 outside_light(const Surface& surface, const Mixture& scatterer, const EnvironmentSample& sample, std::uint32_t k,
                     bool& delta) const {
    delta = sample.delta;
    const Vec3 unshadowed = scatterer.eval(sample.wi) * sample.radiance;
    const auto free = [&] {
      const Vec3 from = surface.offset_toward(sample.wi);
      return world_.may_pass() ? unoccluded({.origin = from, .direction = sample.wi}, k)
                               : world_.escapes(from, sample.wi);
    };
    const bool contributes = !is_zero(unshadowed) && free();
    log_.environment(sample, contributes);
    if (!contributes) return Vec3(0.0);
    const bool shared = weighs_ && !delta;
    const double w_light =
        shared ? power_heuristic(light_count() * sample.pdf_w, bsdf_count() * scatterer.pdf(sample.wi)) : 1.0;
    return unshadowed * transmittance(scatterer.absorption_toward(sample.wi, absorption_), INFINITY) / sample.pdf_w *
           w_light / light_count();
  }

  /// Reflected radiance due to one sampled point on a light.
  Vec3 direct_light(const Surface& surface, const Mixture& scatterer, std::uint32_t k, bool& delta) const {
    const std::optional<LightSample> chosen =
        world_.lights().sample(world_.scene(), surface.p, scatterer.light_normal(), random_.light(k));
    if (!chosen) return Vec3(0.0);
    const LightSample& light = *chosen;
    delta = light.delta;
    const Vec3 f = light.pdf_w > 0.0 ? scatterer.eval(light.wi) : Vec3(0.0);
    const Vec3 unshadowed = f * light.radiance;
    const bool contributes = !is_zero(unshadowed) && lit(surface, light, k);
    log_.light(light, contributes);
    if (!contributes) return Vec3(0.0);
    const double pdf_mis = light.pdf_w_mis * world_.environment().lights_prob();
    const bool shared = weighs_ && !delta;  // whether hits by chance find this light, too
    const double w_light =
        shared ? power_heuristic(light_count() * pdf_mis, bsdf_count() * scatterer.pdf(light.wi)) : 1.0;
    const double distance = glm::distance(surface.p, light.surface.p);
    return unshadowed * transmittance(scatterer.absorption_toward(light.wi, absorption_), distance) / light.pdf_w *
           w_light / light_count();
  }

  /// Whether a shadow ray from vertex `k` reaches the point of a light.
  bool lit(const Surface& surface, const LightSample& light, std::uint32_t k) const {
    const Vec3 from = surface.offset_toward(light.wi), to = light.surface.offset_toward(-light.wi);
    if (!world_.may_pass()) return !world_.occluded(from, to);
    const double distance = glm::length(to - from);
    return !(distance > 0.0) || unoccluded({.origin = from, .direction = (to - from) / distance, .t_max = distance}, k);
  }

  /// Russian roulette. Paths inside a medium carry radiance scaled by its squared index; `eta_scale_` undoes this, so
  /// that the survival of a path does not depend on its medium.
  bool survives(std::uint32_t depth, double u) {
    const bool whitted = integrator_.type == Integrator::Type::whitted;
    if (!whitted && (integrator_.rr_depth == 0 || depth < integrator_.rr_depth)) return true;
    const double q = whitted ? kWhittedSurvival : std::min(max_component(beta_) * eta_scale_, 0.99);
    const bool survived = u < q;
    log_.roulette(survived);
    if (survived) beta_ /= q;
    return survived;
  }

  /// Samples of a strategy that share a vertex; 1 except for `direct`.
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
  const bool samples_lights_, weighs_, counts_passes_;
  std::uint32_t max_depth_ = 1;
  bool black_ = false;  ///< the surface seen by the rounds of `direct` reflects nothing
  const SampleRandom& random_;
  DecisionLog& log_;
  std::uint32_t bounces_ = 0;
  Vec3 beta_{1.0};
  Vec3 absorption_{0.0};  ///< of the medium that the ray is in, per scene unit
  Vec3 radiance_{0.0};
  double eta_scale_ = 1.0;
  std::optional<int> color_;          ///< the one that the path carries after a dispersing material
  std::optional<Previous> previous_;  ///< the previous vertex; none for the camera
};

}  // namespace

Vec3 path_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log) {
  return Path(world, random, log).trace(camera_ray);
}

Vec3 direct_radiance(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log) {
  return Path(world, random, log).trace_direct(camera_ray);
}

}  // namespace etendue::reference
