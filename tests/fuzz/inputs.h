#pragma once
/// How several fuzz targets use their bytes.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "formats/byte_source.h"

namespace etendue::fuzz {

inline void require(bool condition) {
  if (!condition) std::abort();
}

/// A source of all bytes but the first, which chooses the size of the reads. `data` must outlive the source.
inline ByteSource source_of(const std::uint8_t* data, std::size_t size) {
  const std::size_t chunk = (*data & 3) == 0 ? 1 : std::size_t{1} << (2 * (*data & 3));
  return [data, size, chunk, at = std::size_t{1}](char* buffer, std::size_t capacity) mutable {
    const std::size_t count = std::min({capacity, chunk, size - at});
    std::memcpy(buffer, data + at, count);
    at += count;
    return count;
  };
}

}  // namespace etendue::fuzz
