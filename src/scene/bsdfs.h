#pragma once
/// Materials as the user described them; docs/conventions.md, "Materials", has their formulas. Reflectances are factors
/// in [0,1] per Rec. 709 component; an index of refraction is real and relative to vacuum.

#include <cstdint>

#include <glm/glm.hpp>

namespace etendue {

/// Roughness of a surface of microfacets: the root mean square slopes along and across the tangent, times √2.
struct Roughness {
  enum class Distribution : std::uint32_t { beckmann, ggx };
  Distribution distribution = Distribution::beckmann;
  double alpha_u = 0.1;  ///< > 0
  double alpha_v = 0.1;  ///< > 0
};

/// A rough dielectric coat over a diffuse base, one-sided: kd/π + (1 − max kd) · Beckmann microfacets.
struct MicrofacetBsdf {
  glm::dvec3 kd{0.5};
  double alpha = 0.1;
  double int_ior = 1.5046;
  double ext_ior = 1.000277;
};

/// Complex index of refraction η + ik per Rec. 709 component, of a metal in vacuum.
struct ConductorIndex {
  glm::dvec3 eta{0.0};
  glm::dvec3 k{1.0};  ///< with η = 0: reflects everything
};
/// Smooth metal, one-sided.
struct ConductorBsdf {
  ConductorIndex index;
  glm::dvec3 specular_reflectance{1.0};
};
/// Rough metal, one-sided.
struct RoughConductorBsdf {
  ConductorIndex index;
  Roughness roughness;
  glm::dvec3 specular_reflectance{1.0};
};

}  // namespace etendue
