#pragma once
/// Scenes with a known answer, made from a seed: fresh ones on every run, so that no renderer is tuned to a few
/// numbers. The formulas share no code with either renderer.

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "scene/scene.h"

namespace etendue {

/// A scene and the mean luminance of its film.
struct ClosedFormScene {
  Scene scene;
  double expected = 0;
  std::string name;  ///< what it holds, "direct light, 3 polygons, 2 spheres, mis"
};

enum class SceneFamily {
  direct,    ///< a diffuse floor under polygons and spheres that emit, some behind blockers, some turned away or below
             ///< the floor
  furnace,   ///< the inside of an emitting, reflecting box: the geometric series of the albedo
  interior,  ///< a sphere of any material inside an emitting box
  sky,       ///< a diffuse or mirroring square or sphere under a sky with a gradient
  sheet,     ///< one dielectric interface under a sky with a gradient, from both sides
  glass,     ///< a glass sphere under an even sky, seen from outside and inside
  coverage,  ///< an emitting rectangle that covers a part of the pixel, through every reconstruction filter
  crowd,     ///< direct with some sixty small lights, chosen by a tree; half of the scenes with Sobol sets
  camera,    ///< what a camera makes of an emitting rectangle: far cameras
  integrator,   ///< what the other integrators say of simple scenes
  environment,  ///< a diffuse square under a small picture of all directions, turned, in half of the scenes beside a
                ///< lamp
  texture,      ///< a textured floor under a textured lamp
  delta,        ///< lights without extent over a floor, on a sphere, beside lamps and under a sky
  adapter,      ///< a floor and a veil of diffuse materials in random stacks of adapters
  aov,          ///< what is rendered beside a picture, parts of its light, pictures without a background
};
inline constexpr std::array<SceneFamily, 15> kSceneFamilies{
    SceneFamily::direct, SceneFamily::furnace,    SceneFamily::interior,    SceneFamily::sky,
    SceneFamily::sheet,  SceneFamily::glass,      SceneFamily::coverage,    SceneFamily::crowd,
    SceneFamily::camera, SceneFamily::integrator, SceneFamily::environment, SceneFamily::texture,
    SceneFamily::delta,  SceneFamily::adapter,    SceneFamily::aov};
const char* scene_family_name(SceneFamily family);

/// How light is found: naive (by chance), nee (sampled) or mis (both, weighted).
enum class LightStrategy { naive, nee, mis };
const char* light_strategy_name(LightStrategy strategy);

/// Scene number `seed` of a family: a pure function of its arguments.
ClosedFormScene make_closed_form(SceneFamily family, std::uint64_t seed);
/// The same with a given strategy; it makes a difference where something emits and scatters.
ClosedFormScene make_closed_form(SceneFamily family, std::uint64_t seed, LightStrategy strategy);

/// The formulas behind them.
namespace closed_form {

/// Irradiance at the origin, normal `n`, of a convex planar polygon of unit radiance that emits to the side from which
/// its vertices run counter-clockwise; the part below the horizon is cut off [Lambert1760].
double polygon_irradiance(std::span<const glm::dvec3> vertices, const glm::dvec3& n);
/// The same of a sphere that does not hold the origin, horizon included [Hamilton1952].
double sphere_irradiance(const glm::dvec3& center, double radius, const glm::dvec3& n);
/// ∫ max(0, ω·a) max(0, ω·b) dω for unit vectors a and b: the irradiance of a sky max(0, ω·b).
double clamped_cosine_product(const glm::dvec3& a, const glm::dvec3& b);
/// Unpolarised reflectance of the boundary from index `n_o` to `n_t`, cosine `cos_o` in [0,1] [Born1999].
double fresnel_reflectance(double cos_o, double n_o, double n_t);
/// Unpolarised reflectance of a metal of index `eta` + ik seen from vacuum, cosine `cos_o` in [0,1] [Born1999].
double fresnel_reflectance_of_metal(double cos_o, double eta, double k);
/// Share of the (signed, normalised) one-dimensional filter left of `x` pixels.
double filter_share(const ReconstructionFilter& filter, double x);

}  // namespace closed_form
}  // namespace etendue
