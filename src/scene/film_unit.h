#pragma once
/// The unit of the film's sums, chosen so that nothing is refused for being bright; docs/conventions.md, "Film".

#include "scene/bounds.h"
#include "scene/view.h"

namespace etendue {

/// Smallest integer E with every component of radiance that anything of the scene emits <= 2^E, but of a sky's picture
/// its mean and 2^-12 of its largest; 0 for a dark scene. Points and spots, whose light has no bound, count by the
/// irradiance that all of them have at the scene's typical radius, with 22 bits of room above it.
int radiance_exponent(const Scene& scene);

/// What a light without extent adds to a path at one vertex, at most: 2^(E + 20), so that the film takes every path.
double delta_light_limit(int radiance_exponent);

/// The film's exponent for a view of a scene whose emitters have `radiance_exponent` and that fills `bounds`: that
/// itself where light is gathered, 0 for colours and shares, and for what has no bound enough for the least distance
/// that positions can tell apart.
int view_exponent(const View& view, int radiance_exponent, const Bounds& bounds);

/// The same of a scene that is not compiled.
int film_exponent(const Scene& scene, const View& view);

}  // namespace etendue
