/// Feeds arbitrary bytes to the reader of pictures in scenes, which recognises all formats.

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/errors.h"
#include "image/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  try {
    etendue::decode_bitmap(bytes, "fuzz");
  } catch (const etendue::Error&) {  // the only way a reader may refuse
  }
  return 0;
}
