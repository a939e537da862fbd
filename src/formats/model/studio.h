#pragma once
/// What a model needs to be looked at and its file does not say: a camera framed on it, a soft sky, how to sample.

#include "scene/scene.h"

namespace etendue {

/// All of the scene's instances, from the front, to the right and above: +Y is up, as in most files.
void frame_camera(Scene& scene);
/// Soft and grey, brighter above.
void add_studio_sky(Scene& scene);
/// Film and sampler of a scene that names none.
void set_viewer_sampling(Scene& scene);

}  // namespace etendue
