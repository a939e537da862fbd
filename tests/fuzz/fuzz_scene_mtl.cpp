/// Any bytes as a material library: the reader must return materials in range and warnings with their positions,
/// without a fault or an error.

#include <cmath>

#include "formats/model/mtl_reader.h"
#include "inputs.h"

namespace {

using etendue::fuzz::require;

bool is_share(double v) {
  return v >= 0.0 && v <= 1.0;
}

}  // namespace

/// The first byte chooses the size of reads.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  etendue::Diagnostics diagnostics;
  std::map<std::string, etendue::MtlMaterial> materials;
  etendue::read_mtl(etendue::fuzz::source_of(data, size), "fuzz.mtl", materials, diagnostics);
  require(!diagnostics.has_errors());
  for (const auto& [name, m] : materials) {
    for (int i = 0; i < 3; ++i) {
      require(is_share(m.diffuse[i]) && is_share(m.specular[i]));
      require(m.emission[i] >= 0.0 && std::isfinite(m.emission[i]));
    }
    require(is_share(m.opacity) && std::isfinite(m.exponent) && m.exponent >= 0.0 && std::isfinite(m.index));
    require(is_share(m.roughness.value_or(0.0)) && is_share(m.metallic.value_or(0.0)));
    for (const auto& map : {m.diffuse_map, m.emission_map, m.opacity_map}) require(!map || !map->filename.empty());
  }
  return 0;
}
