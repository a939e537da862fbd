#include <algorithm>

#include "reference/camera.h"
#include "reference/integrator.h"
#include "reference/scatterer.h"
#include "reference/texture.h"
#include "reference/walk.h"

namespace etendue::reference {
namespace {

/// Number of segments for which normal and albedo look through mirrors and glass.
constexpr std::uint32_t kMaxSegments = 64;

bool known_at_hit(Aov aov) {
  return aov != Aov::normal && aov != Aov::albedo;
}

Vec3 halves(std::uint32_t number) {
  return {number % 65536u, number / 65536u, 0.0};
}

/// Follows a camera ray to the surface where its value is known.
class Look {
 public:
  Look(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log)
      : world_(world), scene_(world.scene()), camera_ray_(camera_ray), random_(random), log_(log) {}

  Vec3 value() {
    Ray ray = camera_ray_;
    bool from_camera = true;
    for (std::uint32_t segment = 1; segment <= kMaxSegments;) {
      const std::optional<Surface> hit = from_camera ? first_visible(world_, ray, value_, log_) : next_hit(ray);
      if (!hit) {
        if (!hides_sky(segment)) see(world_.environment().radiance(ray.direction));
        break;
      }
      see(emitted_radiance(scene_, *hit, -ray.direction));
      const auto chosen = choose_materials(scene_, *hit, ray.direction, random_, segment - 1);
      bool goes_on = true;
      if (chosen) {
        goes_on = arrive(*hit, *chosen, segment, ray);
      } else {
        log_.lobe(Lobe::passed);
        go_behind(*hit, ray);
      }
      log_.radiance(value_);
      if (!goes_on) return value_;
      if (chosen || scene_.integrator.count_passes) {
        ++segment;
        from_camera = false;
      }
    }
    log_.radiance(value_);
    return value_;
  }

 private:
  bool hides_sky(std::uint32_t segment) const {
    const Integrator& integrator = scene_.integrator;
    return (segment == 1 && integrator.hide_emitters) || (!scattered_ && integrator.hide_background);
  }

  std::optional<Surface> next_hit(const Ray& ray) {
    const std::optional<Surface> hit = world_.closest_hit(ray);
    log_.segment(ray, hit);
    return hit;
  }

  /// For denoisers, lamps and sky contribute their colour to the albedo, up to white.
  void see(const Vec3& radiance) {
    if (scene_.integrator.aov == Aov::albedo) value_ = glm::max(value_, glm::min(throughput_ * radiance, Vec3(1.0)));
  }

  /// Returns false if the value is known; otherwise `ray` has been reflected or refracted by the mirror or glass.
  bool arrive(const Surface& surface, const ChosenMaterials& found, std::uint32_t segment, Ray& ray) {
    const ChosenMaterial& chosen = found.chosen;
    const Aov aov = scene_.integrator.aov;
    if (known_at_hit(aov)) {
      value_ = at_hit(surface, chosen);
      return false;
    }
    if (segment == kMaxSegments) return false;
    const auto scatterer_of = [&](const ChosenMaterial& m) {
      return Scatterer(material_at(scene_, m, surface, ray.direction), m, -ray.direction);
    };
    const Mixture scatterer = found.other ? Mixture(scatterer_of(chosen), found.share, scatterer_of(*found.other))
                                          : Mixture(scatterer_of(chosen));
    const bool delta = scatterer.chosen().delta();
    if (aov == Aov::normal && !delta) {
      value_ = chosen.frame.normal();
      return false;
    }
    const BsdfSample bounce = scatterer.black() ? BsdfSample{} : scatterer.sample(random_.material(segment - 1));
    log_.lobe(bounce.lobe);
    if (bounce.lobe == Lobe::none) return false;
    scattered_ = true;
    throughput_ *= bounce.weight;
    if (!delta) {
      value_ = glm::max(value_, glm::min(throughput_, Vec3(1.0)));
      return false;
    }
    ray = {.origin = surface.offset_toward(bounce.wi), .direction = bounce.wi};
    return true;
  }

  Vec3 at_hit(const Surface& surface, const ChosenMaterial& chosen) const {
    switch (scene_.integrator.aov) {
      case Aov::depth:
        return {glm::dot(surface.p - camera_ray_.origin, camera_ray_.direction), 0.0, 0.0};
      case Aov::position:
        return surface.p;
      case Aov::shading_normal:
        return chosen.frame.normal();
      case Aov::geometric_normal:
        return surface.ng;
      case Aov::uv:
        return Vec3(first_uv(scene_, surface), 0.0);
      case Aov::instance:
        return halves(surface.instance + 1);
      case Aov::primitive:
        return halves(surface.primitive + 1);
      case Aov::material:
        return halves(scene_.instances[surface.instance].material + 1);
      default:
        return Vec3(1.0);  // the ray has hit something
    }
  }

  const World& world_;
  const Scene& scene_;
  const Ray& camera_ray_;
  const SampleRandom& random_;
  DecisionLog& log_;
  bool scattered_ = false;
  Vec3 throughput_{1.0};
  Vec3 value_{0.0};
};

}  // namespace

Vec3 aov_value(const World& world, const Ray& camera_ray, const SampleRandom& random, DecisionLog& log) {
  return Look(world, camera_ray, random, log).value();
}

double aov_weight(const Scene& scene, double weight, std::uint32_t sample) {
  switch (traits(scene.integrator.aov).mean) {
    case AovMean::all:
      return scene.integrator.aov == Aov::hit ? 1.0 : weight / camera_weight(scene.camera);
    case AovMean::hits:
      return 1.0;
    case AovMean::first:
      // The film stores the mean over a set.
      return sample % scene.sampler.set_size() == 0 ? scene.sampler.set_size() : 0.0;
  }
  return weight;
}

}  // namespace etendue::reference
