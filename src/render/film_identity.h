#pragma once
/// What all films of one render agree on.

#include "image/film_file.h"
#include "render/device_team.h"
#include "render/renderer.h"

namespace etendue {

/// The settings of a scene's integrator in one line.
std::string integrator_text(const Scene& scene);

/// Size, film exponent and metadata of the films of this render, without samples. Nothing in it depends on the time or
/// the place of the run.
FilmHeader film_identity(const Scene& scene, std::uint32_t seed);
/// The same with other AOVs than the scene asks for. Throws Error(usage) for one that does not go with its integrator.
FilmHeader film_identity(const Scene& scene, std::uint32_t seed, const std::vector<Aov>& aovs);

/// How the AOVs of such a film are rendered.
AovPlan aov_plan(const Scene& scene, std::uint32_t seed, const FilmHeader& identity);

/// The film samples that hold at least `paths` paths of each pixel: whole sets of the sampler. Throws Error(usage) when
/// they are too many to be numbered.
SampleRange whole_sets(std::uint32_t paths, const Sampler& sampler);

}  // namespace etendue
