#pragma once
/// Memory given back before its owner ends.

#include <vector>

namespace etendue {

/// Empties a vector and frees what it holds. `v = {}` only empties it: that assigns an empty list and keeps the memory.
template <typename T>
void release(std::vector<T>& vector) {
  std::vector<T>().swap(vector);
}

}  // namespace etendue
