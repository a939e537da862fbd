/// Any bytes as a glTF asset, text or binary: the reader must return a scene or an error, without a fault.

#include "gltf_assets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  etendue::fuzz::read_any_asset({bytes, bytes + size});
  return 0;
}
