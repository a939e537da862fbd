#pragma once
/// The invariants of every scene, whoever made it: a reader, a test, a program that uses the library.

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "scene/diagnostics.h"
#include "scene/light_sources.h"
#include "scene/scene.h"

namespace etendue {

/// Position of a field of the object at `object` in its file, by its name in scene.h; nothing if the file does not give
/// it.
using LocateField = std::function<std::optional<SourcePosition>(const SourcePosition& object, std::string_view field)>;

/// Reports as errors all violations of what renderers rely on: indices within their tables, finite numbers within the
/// limits of scene/limits.h, near < far, invertible transforms, emitters with an area. Linear in the size of the scene.
/// Without `locate` a finding has the position of its object.
void check_invariants(const Scene& scene, Diagnostics& diagnostics, const LocateField& locate = {});

/// The part of it that a change of a material's numbers may break.
void check_materials(const std::vector<Material>& materials, Diagnostics& diagnostics, const LocateField& locate = {});

/// The part of it that a change of a light's numbers may break.
void check_lights(const LightSources& lights, Diagnostics& diagnostics);

/// Throws Error(scene) with the first finding of check_invariants, if there is one.
void require_invariants(const Scene& scene);

}  // namespace etendue
