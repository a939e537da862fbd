#include "scene/view.h"

#include <fmt/format.h>

namespace etendue {
namespace {

bool is_light(Aov aov) {
  return aov == Aov::direct || aov == Aov::indirect;
}

}  // namespace

View aov_view(const View& view, Aov aov) {
  View out = view;
  Integrator& integrator = out.integrator;
  if (is_light(aov)) {
    integrator.light_part = aov == Aov::direct ? Integrator::LightPart::direct : Integrator::LightPart::indirect;
    return out;
  }
  integrator.type = Integrator::Type::aov;
  integrator.aov = aov;
  // Random numbers are counted by segments: masks let the same rays pass.
  integrator.count_passes = counts_passes(view.integrator);
  integrator.hide_emitters = gathers_light(view.integrator) && view.integrator.hide_emitters;
  return out;
}

std::string aov_complaint(const Integrator& integrator, Aov aov) {
  if (!is_light(aov) || gathers_light(integrator)) return "";
  return fmt::format(
      "the AOV {} is a part of the light that path, direct or whitted gathers; another integrator has none",
      traits(aov).name);
}

}  // namespace etendue
