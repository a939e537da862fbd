#pragma once
/// glTF 2.0 assets as scenes; docs/gltf.md says what of them is read.
///
/// The JSON is parsed by JSON for Modern C++. Of the parsers that know glTF itself Debian 12 has tinygltf (2.7): it
/// takes values of wrong types for missing ones, opens every buffer at once and copies it, leaves all ranges unchecked,
/// and forgets where in the file a thing stands. A reader of files that come from strangers would have to do all of it
/// again.

#include <memory>
#include <optional>
#include <string>

#include "formats/gltf/gltf_document.h"
#include "formats/read_options.h"
#include "scene/diagnostics.h"
#include "scene/scene.h"

namespace etendue {

/// Nothing after an error; says what it added and what it left out. Only files in the folder of the asset are opened.
std::optional<Scene> read_gltf(const std::string& path, const ReadOptions& options, Diagnostics& diagnostics);
/// The same from bytes; `open` opens what its URIs name.
std::optional<Scene> read_gltf(std::shared_ptr<const ByteStore> bytes, const std::string& path, GltfFileOpener open,
                               const ReadOptions& options, Diagnostics& diagnostics);

}  // namespace etendue
