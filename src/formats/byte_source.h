#pragma once
/// Where the readers of mesh files get their bytes.

#include <cstddef>
#include <functional>

namespace etendue {

/// Fills a buffer with the next bytes of a file and returns how many there were; 0 at the end.
using ByteSource = std::function<std::size_t(char* buffer, std::size_t capacity)>;

}  // namespace etendue
