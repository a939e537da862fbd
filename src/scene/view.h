#pragma once
/// How a scene is looked at: what may change without anything being compiled again.

#include <string>

#include "scene/scene.h"

namespace etendue {

struct View {
  Camera camera;  ///< with the size of the film and its filter
  Sampler sampler;
  Integrator integrator;  ///< `light_sampler` is the scene's: it decides what is compiled, and is not looked at here
};

/// The scene's own.
inline View view_of(const Scene& scene) {
  return {scene.camera, scene.sampler, scene.integrator};
}

/// What renders an AOV beside the picture of `view`: the same samples, looked at by another integrator.
View aov_view(const View& view, Aov aov);

/// Why the AOV cannot be rendered beside what the integrator computes; "" where it can.
std::string aov_complaint(const Integrator& integrator, Aov aov);

}  // namespace etendue
