#pragma once
/// The output of `etendue render --stats`, and heat maps.

#include <string>

#include "core/json.h"
#include "gpu/gpu_renderer.h"
#include "image/image.h"

namespace etendue::cli {

/// Rays, nodes and primitives by class, active lanes, and passes; for stdout.
std::string stats_text(const RenderProfile& profile, const GpuTimings& timings);
Json stats_json(const RenderProfile& profile, const GpuTimings& timings);

/// Red: nodes, green: primitives, blue: rays, each per sample.
Image heat_values(const RenderProfile& profile);

/// Nodes and primitives per sample in false colour, black to white through violet, red and yellow; `white` returns the
/// value shown as white, which one pixel in 200 exceeds.
Image heat_colors(const RenderProfile& profile, float& white);

/// Writes heat_values as EXR or heat_colors as PNG, by the end of the name. Throws Error(file).
void write_heat_map(const std::string& path, const RenderProfile& profile);

}  // namespace etendue::cli
