#pragma once
/// Materials as described by the user; docs/conventions.md, "Materials", has their formulas. Reflectances are factors
/// in [0,1] per Rec. 709 component; an index of refraction is real and relative to vacuum. Textured reflectances and
/// roughnesses are clamped to the range of constants.

#include <cstdint>
#include <limits>

#include <glm/glm.hpp>

#include "scene/texture.h"

namespace etendue {

/// Burley's principled material, with the parameters of Mitsuba's principled; numbers are in [0,1].
struct PrincipledBsdf {
  ColorParameter base_color{glm::dvec3(0.5)};
  ScalarParameter roughness{0.5};
  ScalarParameter metallic{0.0};
  ScalarParameter anisotropic{0.0};
  ScalarParameter spec_trans{0.0};  ///< refracted share of the non-metallic part, instead of the diffuse base
  ScalarParameter spec_tint{0.0};
  ScalarParameter sheen{0.0};
  ScalarParameter clearcoat{0.0};
  ScalarParameter sheen_tint{0.0};
  ScalarParameter flatness{0.0};
  ScalarParameter clearcoat_gloss{0.0};
  ScalarParameter eta{1.5};  ///< index of refraction inside over that outside
};

/// Burley's principled material for infinitely thin sheets, the same on both sides, with the parameters of Mitsuba's
/// principledthin; numbers are in [0,1] unless stated otherwise.
struct PrincipledThinBsdf {
  ColorParameter base_color{glm::dvec3(0.5)};
  ScalarParameter roughness{0.5};
  ScalarParameter anisotropic{0.0};
  ScalarParameter spec_trans{0.0};  ///< share of a rough pane instead of the diffuse base
  ScalarParameter spec_tint{0.0};
  ScalarParameter sheen{0.0};
  ScalarParameter sheen_tint{0.0};
  ScalarParameter flatness{0.0};
  ScalarParameter diff_trans{0.0};  ///< in [0,2]: twice the share of diffuse light that is transmitted
  ScalarParameter eta{1.5};         ///< index of refraction inside over that outside
};

/// The material of glTF 2.0: metallic-roughness and the Khronos extensions for transmission, volume, ior, specular,
/// clearcoat, sheen, anisotropy, iridescence and diffuse transmission, with their parameters. Numbers are in [0,1]
/// unless stated otherwise. A reader of glTF files turns each of their materials into one of these; double-sided opaque
/// ones are inside a TwoSidedAdapter, alpha is a MaskAdapter, normal maps are NormalMapAdapters. docs/conventions.md,
/// "glTF".
struct GltfBsdf {
  ColorParameter base_color{glm::dvec3(1.0)};
  ScalarParameter metallic{1.0};
  ScalarParameter roughness{1.0};                  ///< α of the microfacets is its square
  ScalarParameter ior{1.5};                        ///< at least 1; of the non-metallic part
  ScalarParameter specular{1.0};                   ///< factor for its reflectance
  ColorParameter specular_color{glm::dvec3(1.0)};  ///< factor for its reflectance at normal incidence, in [0,100]
  ScalarParameter transmission{0.0};               ///< share of it that is clear instead of diffuse
  ScalarParameter diffuse_transmission{0.0};       ///< share of the diffuse rest that is transmitted
  ColorParameter diffuse_transmission_color{glm::dvec3(1.0)};
  ScalarParameter clearcoat{0.0};
  ScalarParameter clearcoat_roughness{0.0};
  ColorParameter sheen_color{glm::dvec3(0.0)};
  ScalarParameter sheen_roughness{0.0};
  ScalarParameter anisotropy{0.0};
  double anisotropy_rotation = 0.0;  ///< from the tangent, radians
  /// Where there is a texture, a further rotation at each point: by the angle of (2 red − 1, 2 green − 1).
  ColorParameter anisotropy_directions{glm::dvec3(1.0)};
  ScalarParameter iridescence{0.0};
  ScalarParameter iridescence_ior{1.3};          ///< of the film, in [1,10]
  ScalarParameter iridescence_thickness{400.0};  ///< of the film, nanometres, in [0,10000]
  bool thin = true;         ///< a thin sheet; otherwise the surface of a solid, which has a thickness in glTF
  double dispersion = 0.0;  ///< for a solid: 20 divided by its Abbe number, in [0,kMaxDispersion]
  /// The coat has the surface's normal, whatever normal maps apply to the base, or that of a normal map of its own, as
  /// in NormalMapAdapter.
  bool coat_keeps_normal = false;
  ColorParameter coat_normals{glm::dvec3(1.0)};
  bool coat_vertex_tangents = false;
  glm::dvec3 attenuation_color{1.0};  ///< above 0: colour of white light in a solid after attenuation_distance
  double attenuation_distance = std::numeric_limits<double>::infinity();  ///< scene units, above 0
  /// State of a path that has hit the material; not part of a scene.
  struct Met {
    double bending_index = 0.0;             ///< of its colour; 0: as `ior`
    glm::dvec3 coat_normal{0.0, 0.0, 1.0};  ///< in the frame of the material
  };
  Met met = {};
};

/// No material: light passes through unchanged.
struct NullBsdf {};

/// Roughness of a microfacet surface: the root mean square slopes along and across the tangent, times √2.
struct Roughness {
  enum class Distribution : std::uint32_t { beckmann, ggx };
  Distribution distribution = Distribution::beckmann;
  ScalarParameter alpha_u{0.1};  ///< > 0
  ScalarParameter alpha_v{0.1};  ///< > 0
};

/// A rough dielectric coat over a diffuse base, one-sided: kd/π + (1 − max kd) · Beckmann microfacets.
struct MicrofacetBsdf {
  ColorParameter kd{glm::dvec3(0.5)};
  ScalarParameter alpha{0.1};
  double int_ior = 1.5046;
  double ext_ior = 1.000277;
};

/// Complex index of refraction η + ik per Rec. 709 component, of a metal in vacuum.
struct ConductorIndex {
  ColorParameter eta{glm::dvec3(0.0)};
  ColorParameter k{glm::dvec3(1.0)};  ///< with η = 0: reflects everything
};
/// Smooth metal, one-sided.
struct ConductorBsdf {
  ConductorIndex index;
  ColorParameter specular_reflectance{glm::dvec3(1.0)};
};
/// Rough metal, one-sided.
struct RoughConductorBsdf {
  ConductorIndex index;
  Roughness roughness;
  ColorParameter specular_reflectance{glm::dvec3(1.0)};
};

/// Rough boundary between two clear media; the normal points to the exterior.
struct RoughDielectricBsdf {
  double int_ior = 1.5046;
  double ext_ior = 1.000277;  ///< other than int_ior
  Roughness roughness;
  ColorParameter specular_reflectance{glm::dvec3(1.0)};
  ColorParameter specular_transmittance{glm::dvec3(1.0)};
};
/// An infinitely thin pane with two smooth faces.
struct ThinDielectricBsdf {
  double int_ior = 1.5046;
  double ext_ior = 1.000277;
  ColorParameter specular_reflectance{glm::dvec3(1.0)};
  ColorParameter specular_transmittance{glm::dvec3(1.0)};
};

/// A diffuse base inside a clear coat, one-sided. `nonlinear`: light reflected back and forth under the coat takes on
/// the colour of the base each time.
struct PlasticBsdf {
  ColorParameter diffuse_reflectance{glm::dvec3(0.5)};
  ColorParameter specular_reflectance{glm::dvec3(1.0)};
  double int_ior = 1.49;
  double ext_ior = 1.000277;
  bool nonlinear = false;
};
/// The same with a rough coat.
struct RoughPlasticBsdf {
  ColorParameter diffuse_reflectance{glm::dvec3(0.5)};
  ColorParameter specular_reflectance{glm::dvec3(1.0)};
  double int_ior = 1.49;
  double ext_ior = 1.000277;
  bool nonlinear = false;
  Roughness::Distribution distribution = Roughness::Distribution::beckmann;
  ScalarParameter alpha{0.1};
};

}  // namespace etendue
