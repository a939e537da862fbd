#pragma once
/// Scenes that are written for Mitsuba 0.6, 2 or 3, as docs/mitsuba.md describes it: text in, plain structs out.

#include <memory>
#include <optional>

#include "formats/mitsuba/mitsuba_files.h"
#include "formats/read_options.h"
#include "scene/scene.h"

namespace etendue {

/// The scene of a document for which is_mitsuba() holds; nothing after an error. `files` reads what it names.
std::optional<Scene> parse_mitsuba_scene(std::unique_ptr<XmlDocument> document, const ReadOptions& options,
                                         const MitsubaFiles& files, Diagnostics& diagnostics);

}  // namespace etendue
