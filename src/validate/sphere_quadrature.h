#pragma once
/// Integrals of a density over cells of the sphere.

#include <functional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace etendue {

/// Density w.r.t. solid angle at many directions at once (a device answers thousands as fast as one).
using SphereDensity = std::function<std::vector<double>(std::span<const glm::dvec3>)>;

/// The unit vector of (cos θ, φ); +Z is θ = 0.
glm::dvec3 spherical_direction(double cos_theta, double phi);

/// ∫ density dω over each of `rings` × `sectors` cells even in cos θ ∈ [−1, 1] and φ ∈ [0, 2π), ring by ring from cos θ
/// = −1. Adaptive: a cell is quartered until 4 × 4-point Gauss–Legendre of the whole and of its quarters agree to
/// `tolerance`, at most 6 times; kinks such as the horizon need not lie on cell borders.
std::vector<double> integrate_cells(const SphereDensity& density, int rings, int sectors, double tolerance = 1e-7);

}  // namespace etendue
