#pragma once
/// How the tests get a renderer: they never choose or look inside one.

#include <functional>
#include <memory>
#include <string>

#include "render/renderer.h"
#include "render/shared_scene.h"

namespace etendue {

/// Makes a renderer of `scene` with these settings; throws Error when it cannot. What it compiles stays with the scene.
using RendererFactory =
    std::function<std::unique_ptr<Renderer>(const SharedScene& scene, const RenderSettings& settings)>;

/// How the device is called where there is only one.
inline constexpr const char* kOnlyDeviceLabel = "device";

/// A device and how it is called: by its number, where there are several.
struct LabelledFactory {
  std::string label;
  RendererFactory make;
};

}  // namespace etendue
