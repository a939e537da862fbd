#pragma once
/// Reads scenes for Mitsuba 0.6, 2 and 3 (docs/mitsuba.md): text in, plain structs out.

#include <memory>
#include <optional>

#include "formats/mitsuba/mitsuba_files.h"
#include "formats/read_options.h"
#include "scene/scene.h"

namespace etendue {

/// The scene in a document for which is_mitsuba() is true; nothing after an error. `files` reads the files that it
/// names.
std::optional<Scene> parse_mitsuba_scene(std::unique_ptr<XmlDocument> document, const ReadOptions& options,
                                         const MitsubaFiles& files, Diagnostics& diagnostics);

}  // namespace etendue
