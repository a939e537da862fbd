/// Any bytes as a .serialized file: the reader must return a mesh or an error, without a fault.

#include <cstdint>
#include <cstdlib>
#include <span>

#include "formats/serialized/serialized_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  etendue::Diagnostics diagnostics;
  const auto bytes = std::as_bytes(std::span(data, size));
  for (const std::int64_t index : {0, 1}) {
    const auto file = etendue::read_serialized(bytes, "fuzz.serialized", index, diagnostics);
    if (!file) continue;
    for (const glm::uvec3& t : file->mesh.triangles) {
      for (const std::uint32_t vertex : {t.x, t.y, t.z}) {
        if (vertex >= file->mesh.positions.size()) std::abort();
      }
    }
  }
  return 0;
}
