#pragma once
/// The CPU reference: double precision, plain on purpose, written from the papers. The device is compared with it
/// sample by sample, so it follows docs/conventions.md to the letter and shares nothing with the device path but that
/// page.

#include <memory>

#include "render/renderer.h"

namespace etendue {

/// Builds what rendering needs; the scene is copied. Uses `thread_count()` threads (core/parallel.h).
std::unique_ptr<Renderer> make_reference_renderer(const Scene& scene, const RenderSettings& settings);

/// The reference, shaken by what single precision does to the points that rays meet (World::Rounding::single). Where
/// its samples part from those of the reference, rounding alone is the reason: what a device may differ by in this
/// scene.
std::unique_ptr<Renderer> make_shaken_reference_renderer(const Scene& scene, const RenderSettings& settings);

}  // namespace etendue
