/// Feeds arbitrary bytes to the reader of film files. It does not check the checksum, which would reject every change.

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/errors.h"
#include "image/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  try {
    etendue::decode_film(bytes, "fuzz.exr", false);
  } catch (const etendue::Error&) {  // the only way a reader may refuse
  }
  return 0;
}
