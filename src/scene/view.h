#pragma once
/// How a scene is viewed: settings that may change without recompiling anything.

#include <string>

#include "scene/scene.h"

namespace etendue {

struct View {
  Camera camera;  ///< with the size of the film and its filter
  Sampler sampler;
  Integrator integrator;  ///< `light_sampler` is taken from the scene, where it determines what is compiled; here it is
                          ///< ignored
};

/// The scene's own.
inline View view_of(const Scene& scene) {
  return {scene.camera, scene.sampler, scene.integrator};
}

/// The integrator for an AOV of `view`: the same samples, with another integrator.
View aov_view(const View& view, Aov aov);

/// Why the AOV cannot be rendered with this integrator; "" if it can.
std::string aov_complaint(const Integrator& integrator, Aov aov);

}  // namespace etendue
