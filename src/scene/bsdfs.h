#pragma once
/// Materials as the user described them; docs/conventions.md, "Materials", has their formulas. Reflectances are factors
/// in [0,1] per Rec. 709 component; an index of refraction is real and relative to vacuum.

#include <cstdint>

#include <glm/glm.hpp>

namespace etendue {

/// Nothing: light passes as if the surface were not there.
struct NullBsdf {};

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

/// Rough boundary between two clear media; the normal points to the exterior.
struct RoughDielectricBsdf {
  double int_ior = 1.5046;
  double ext_ior = 1.000277;  ///< other than int_ior
  Roughness roughness;
  glm::dvec3 specular_reflectance{1.0};
  glm::dvec3 specular_transmittance{1.0};
};
/// A pane whose two smooth faces lie together.
struct ThinDielectricBsdf {
  double int_ior = 1.5046;
  double ext_ior = 1.000277;
  glm::dvec3 specular_reflectance{1.0};
  glm::dvec3 specular_transmittance{1.0};
};

/// A diffuse base inside a clear coat, one-sided. `nonlinear`: light that is reflected to and fro below the coat takes
/// the colour of the base each time.
struct PlasticBsdf {
  glm::dvec3 diffuse_reflectance{0.5};
  glm::dvec3 specular_reflectance{1.0};
  double int_ior = 1.49;
  double ext_ior = 1.000277;
  bool nonlinear = false;
};
/// The same with a rough coat.
struct RoughPlasticBsdf {
  glm::dvec3 diffuse_reflectance{0.5};
  glm::dvec3 specular_reflectance{1.0};
  double int_ior = 1.49;
  double ext_ior = 1.000277;
  bool nonlinear = false;
  Roughness::Distribution distribution = Roughness::Distribution::beckmann;
  double alpha = 0.1;
};

}  // namespace etendue
