/// Feeds arbitrary bytes to the reader of JPEG pictures.

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/errors.h"
#include "image/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  try {
    etendue::decode_jpeg(bytes, "fuzz.jpg");
  } catch (const etendue::Error&) {  // the only way a reader may refuse
  }
  return 0;
}
