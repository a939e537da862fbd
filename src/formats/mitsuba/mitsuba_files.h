#pragma once
/// How files that a Mitsuba scene names are read. Tests have them in memory.

#include <functional>
#include <optional>
#include <string>

#include "formats/mitsuba/mitsuba_document.h"
#include "formats/nori/nori_reader.h"
#include "formats/serialized/serialized_reader.h"
#include "image/bitmap.h"

namespace etendue {

struct MitsubaFiles {
  MeshLoader mesh;
  TextLoader text;  ///< for included files
  std::function<std::optional<SerializedMesh>(const std::string& path, std::int64_t index, Diagnostics&)> serialized;
  std::function<Bitmap(const std::string& path)> picture = [](const std::string& path) { return read_bitmap(path); };
};

/// Readers of the file system.
MitsubaFiles mitsuba_files();

}  // namespace etendue
