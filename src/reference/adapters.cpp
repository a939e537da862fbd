#include "reference/adapters.h"

#include "reference/texture.h"

namespace etendue::reference {
namespace {

/// On the way from an adapter to a material.
struct Chooser {
  const Scene& scene;
  const Surface& surface;
  const Vec3& d;
  const SampleRandom& random;
  SampleRandom::Decision decision;
  std::uint32_t row;
  Frame frame;

  // Each goes on to a row, or says that the ray passes.
  bool step(const TwoSidedAdapter& adapter) {
    const bool behind = glm::dot(d, frame.normal()) > 0.0;
    if (behind) frame = frame.mirrored();
    row = behind ? adapter.back : adapter.front;
    return true;
  }
  bool step(const MaskAdapter& mask) {
    if (!(random.choice(decision, row) < at_point(scene, mask.opacity, surface))) return false;
    row = mask.inner;
    return true;
  }
  bool step(const BlendAdapter& blend) {
    row = random.choice(decision, row) < at_point(scene, blend.weight, surface) ? blend.second : blend.first;
    return true;
  }
};

}  // namespace

std::optional<ChosenMaterial> choose_material(const Scene& scene, const Surface& surface, const Vec3& d,
                                              const SampleRandom& random, std::uint32_t k, bool shadow_ray) {
  Chooser chooser{.scene = scene,
                  .surface = surface,
                  .d = d,
                  .random = random,
                  .decision = {k, surface.instance, surface.primitive, glm::dot(d, surface.ng) > 0.0, shadow_ray},
                  .row = scene.instances[surface.instance].material,
                  .frame = Frame(surface.ns)};
  for (;;) {
    const Material& material = scene.materials[chooser.row];
    if (!material.adapter) {
      if (std::holds_alternative<NullBsdf>(material.bsdf)) return std::nullopt;
      return ChosenMaterial{chooser.row, chooser.frame};
    }
    if (!std::visit([&](const auto& adapter) { return chooser.step(adapter); }, *material.adapter)) return std::nullopt;
  }
}

}  // namespace etendue::reference
