#pragma once
/// Who finds what a ray meets.

namespace etendue {

enum class Traversal {
  automatic,  ///< the tree
  tree,       ///< kernels walk a tree of our own, on any device
  query,      ///< the driver walks its acceleration structures, where a device has ray queries
};

}  // namespace etendue
