#include "validate/sphere_quadrature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace etendue {
namespace {

/// Nodes and weights of the 4-point Gauss–Legendre rule on [0, 1].
constexpr std::array<double, 4> kNodes{0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                       0.9305681557970263};
constexpr std::array<double, 4> kWeights{0.17392742256872692, 0.32607257743127307, 0.32607257743127307,
                                         0.17392742256872692};
constexpr int kMaxHalvings = 6;

/// A rectangle in (cos θ, φ) that belongs to a cell, with the estimate of its parent's rule.
struct Patch {
  double z0, z1, phi0, phi1;
  std::size_t cell;
};

void append_nodes(const Patch& p, std::vector<glm::dvec3>& directions) {
  for (const double u : kNodes) {
    for (const double v : kNodes) {
      directions.push_back(spherical_direction(p.z0 + u * (p.z1 - p.z0), p.phi0 + v * (p.phi1 - p.phi0)));
    }
  }
}

double apply_rule(const Patch& p, const double* values) {
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) sum += kWeights[i] * kWeights[j] * values[4 * i + j];
  }
  return sum * (p.z1 - p.z0) * (p.phi1 - p.phi0);  // dω = d cos θ dφ
}

std::vector<double> estimate(const SphereDensity& density, const std::vector<Patch>& patches) {
  std::vector<glm::dvec3> directions;
  directions.reserve(16 * patches.size());
  for (const Patch& p : patches) append_nodes(p, directions);
  const std::vector<double> values = density(directions);
  std::vector<double> sums;
  sums.reserve(patches.size());
  for (std::size_t i = 0; i < patches.size(); ++i) sums.push_back(apply_rule(patches[i], values.data() + 16 * i));
  return sums;
}

std::vector<Patch> quarters(const std::vector<Patch>& patches) {
  std::vector<Patch> out;
  out.reserve(4 * patches.size());
  for (const Patch& p : patches) {
    const double z = 0.5 * (p.z0 + p.z1), phi = 0.5 * (p.phi0 + p.phi1);
    for (const Patch& q : {Patch{p.z0, z, p.phi0, phi, p.cell},
                           {p.z0, z, phi, p.phi1, p.cell},
                           {z, p.z1, p.phi0, phi, p.cell},
                           {z, p.z1, phi, p.phi1, p.cell}})
      out.push_back(q);
  }
  return out;
}

/// Adds the integrals of the patches to their cells.
void integrate_patches(const SphereDensity& density, std::vector<Patch> patches, double tolerance,
                       std::vector<double>& cells) {
  std::vector<double> whole = estimate(density, patches);
  for (int halving = 1; !patches.empty(); ++halving) {
    const std::vector<Patch> parts = quarters(patches);
    const std::vector<double> part = estimate(density, parts);
    std::vector<Patch> unsettled;
    std::vector<double> unsettled_sums;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      const double sum = part[4 * i] + part[4 * i + 1] + part[4 * i + 2] + part[4 * i + 3];
      if (std::abs(sum - whole[i]) <= tolerance || halving == kMaxHalvings || std::isnan(sum)) {
        cells[patches[i].cell] += sum;
        continue;
      }
      unsettled.insert(unsettled.end(), parts.begin() + 4 * i, parts.begin() + 4 * (i + 1));
      unsettled_sums.insert(unsettled_sums.end(), part.begin() + 4 * i, part.begin() + 4 * (i + 1));
    }
    patches = std::move(unsettled);
    whole = std::move(unsettled_sums);
  }
}

}  // namespace

glm::dvec3 spherical_direction(double cos_theta, double phi) {
  const double sin_theta = std::sqrt(std::max(0.0, 1.0 - cos_theta * cos_theta));
  return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), cos_theta};
}

std::vector<double> integrate_cells(const SphereDensity& density, int rings, int sectors, double tolerance) {
  std::vector<double> cells(static_cast<std::size_t>(rings) * sectors, 0.0);
  // Ring by ring, so that fine grids need little memory.
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<Patch> patches;
    for (int sector = 0; sector < sectors; ++sector) {
      constexpr double kTurn = 2.0 * std::numbers::pi;
      patches.push_back({-1.0 + 2.0 * ring / rings, -1.0 + 2.0 * (ring + 1) / rings, kTurn * sector / sectors,
                         kTurn * (sector + 1) / sectors, static_cast<std::size_t>(ring) * sectors + sector});
    }
    integrate_patches(density, std::move(patches), tolerance, cells);
  }
  return cells;
}

}  // namespace etendue
