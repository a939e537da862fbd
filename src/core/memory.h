#pragma once
/// Releasing memory early, and the amount available.

#include <cstdint>
#include <vector>

namespace etendue {

/// Empties a vector and frees its memory. `v = {}` would only empty it, because it assigns an empty list and keeps the
/// memory.
template <typename T>
void release(std::vector<T>& vector) {
  std::vector<T>().swap(vector);
}

/// Bytes of memory available on this machine without displacing others; the largest number if the system does not tell.
std::uint64_t available_memory();

}  // namespace etendue
