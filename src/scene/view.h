#pragma once
/// How a scene is looked at: what may change without anything being compiled again.

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

}  // namespace etendue
