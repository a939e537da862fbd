#pragma once
/// The facts that all films of one render have in common.

#include "image/film_file.h"
#include "render/device_team.h"
#include "render/renderer.h"

namespace etendue {

/// The settings of a scene's integrator in one line.
std::string integrator_text(const Scene& scene);

/// Size, film exponent and metadata of the films of this render, without samples. It does not depend on when or where
/// the render runs.
FilmHeader film_identity(const Scene& scene, std::uint32_t seed);
/// The same, with other AOVs than those of the scene. Throws Error(usage) for an AOV that its integrator does not
/// support.
FilmHeader film_identity(const Scene& scene, std::uint32_t seed, const std::vector<Aov>& aovs);

/// The settings with which the AOVs of such a film are rendered.
AovPlan aov_plan(const Scene& scene, std::uint32_t seed, const FilmHeader& identity);

/// The film samples that hold at least `paths` paths of each pixel: whole sets of the sampler. Throws Error(usage) if
/// there are too many to be numbered.
SampleRange whole_sets(std::uint32_t paths, const Sampler& sampler);

}  // namespace etendue
