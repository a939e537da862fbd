#include "formats/mitsuba/mitsuba_files.h"

#include "formats/mesh_formats.h"
#include "formats/scene_text.h"

namespace etendue {

MitsubaFiles mitsuba_files() {
  return {read_mesh_file, read_scene_text, [](const std::string& path, std::int64_t index, Diagnostics& diagnostics) {
            return read_serialized(path, index, diagnostics);
          }};
}

}  // namespace etendue
