#pragma once
/// The map from world space to normalised scene coordinates.

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace etendue {

/// p ↦ (p − center) · scale, with `scale` a power of two so that it costs no precision.
struct Normalization {
  glm::dvec3 center{0.0};
  double scale = 1.0;
  glm::vec3 point(const glm::dvec3& p) const { return glm::vec3((p - center) * scale); }
};

/// Centres the scene on the component-wise median of its primitives' centroids (where most of the geometry is, even
/// above a huge ground sphere) and scales the farthest coordinate into [1/2, 1].
Normalization find_normalization(const Scene& scene);

}  // namespace etendue
