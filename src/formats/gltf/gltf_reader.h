#pragma once
/// Reads glTF 2.0 assets as scenes; docs/gltf.md says which parts are supported.
///
/// JSON for Modern C++ parses the JSON. The glTF parser that Debian 12 has, tinygltf 2.7, treats values of the wrong
/// type as missing, opens and copies all buffers at once, checks no ranges, and does not keep positions for messages. A
/// reader of files from strangers would have to do all of this again.

#include <memory>
#include <optional>
#include <string>

#include "formats/gltf/gltf_document.h"
#include "formats/read_options.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// Returns nothing after an error. Reports what was added or left out. Only files in the asset's folder are opened.
std::optional<Scene> read_gltf(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics);
/// The same for an asset in memory; `open` opens the files that its URIs name.
std::optional<Scene> read_gltf(std::shared_ptr<const ByteStore> bytes, const std::string& path, GltfFileOpener open,
                               const ReadOptions& options, Diagnostics& diagnostics);

}  // namespace etendue
