#pragma once
/// How the tests get a renderer: they never choose or look inside one.

#include <functional>
#include <memory>

#include "render/renderer.h"

namespace etendue {

/// Makes a renderer of `scene` with these settings; throws Error when it cannot.
using RendererFactory = std::function<std::unique_ptr<Renderer>(const Scene& scene, const RenderSettings& settings)>;

}  // namespace etendue
