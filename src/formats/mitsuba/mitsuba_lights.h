#pragma once
/// Reads Mitsuba's lights without extent: point, spot, projector, directional.

#include "formats/mitsuba/mitsuba_textures.h"

namespace etendue {

bool is_mitsuba_delta_light(std::string_view type);

/// Problems are reported.
DeltaLight read_mitsuba_delta_light(const MitsubaObject& object, MitsubaTextures& textures, const Scene& scene,
                                    const MitsubaContext& context);

}  // namespace etendue
