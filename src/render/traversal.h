#pragma once
/// What traverses the scene to find hits.

namespace etendue {

enum class Traversal {
  automatic,  ///< the tree
  tree,       ///< kernels traverse Etendue's own tree, on any device
  query,      ///< the driver traverses its acceleration structures, on devices with ray queries
};

}  // namespace etendue
