#pragma once
/// <emitter> of a point, spot, projector or direction → DeltaLight.

#include <functional>

#include "formats/dialect/object.h"
#include "scene/scene.h"

namespace etendue {

/// Whether the type is one of them.
bool is_delta_light(std::string_view type);

/// The light; problems are reported. `read_textured` makes a parameter of the texture that stands for a property.
DeltaLight read_delta_light(const Object& object,
                            const std::function<ColorParameter(const Object&, const char*)>& read_textured,
                            Diagnostics& sink);

}  // namespace etendue
