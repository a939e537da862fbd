#pragma once
/// Memory given back before its owner ends, and how much there is.

#include <cstdint>
#include <vector>

namespace etendue {

/// Empties a vector and frees what it holds. `v = {}` only empties it: that assigns an empty list and keeps the memory.
template <typename T>
void release(std::vector<T>& vector) {
  std::vector<T>().swap(vector);
}

/// Bytes of this machine that can be used without others having to give way; the largest number where the system does
/// not say.
std::uint64_t available_memory();

}  // namespace etendue
