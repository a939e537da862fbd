#include "render/film_identity.h"

#include <algorithm>
#include <limits>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/printable.h"
#include "core/version.h"
#include "scene/film_unit.h"

namespace etendue {

std::string integrator_text(const Scene& scene) {
  const Integrator& integrator = scene.integrator;
  const std::string hidden = std::string(integrator.hide_emitters ? " hideEmitters" : "") +
                             (integrator.hide_background ? " hideBackground" : "");
  const std::string tree = uses_light_tree(scene) ? " lightSampler=tree" : "";
  const glm::dvec3 &p = integrator.light.position, &e = integrator.light.energy;
  switch (integrator.type) {
    case Integrator::Type::path:
      break;
    case Integrator::Type::normals:
      return "normals";
    case Integrator::Type::absolute_normals:
      return "normals absolute";
    case Integrator::Type::direct:
      return fmt::format("direct emitterSamples={} bsdfSamples={}{}{}", integrator.emitter_samples,
                         integrator.bsdf_samples, tree, hidden);
    case Integrator::Type::whitted:
      return "whitted" + tree + hidden;
    case Integrator::Type::simple:
      return fmt::format("simple position={},{},{} energy={},{},{}", p.x, p.y, p.z, e.x, e.y, e.z);
    case Integrator::Type::ambient_occlusion:
      return fmt::format("ao length={}", integrator.length);
    case Integrator::Type::visibility:
      return fmt::format("av length={}", integrator.length);
    case Integrator::Type::depth:
      return "depth";
    case Integrator::Type::distance:
      return "distance";
    case Integrator::Type::aov:
      return fmt::format("aov {}", traits(integrator.aov).name);
  }
  const std::string passes = integrator.count_passes ? "" : " countPasses=false";
  return fmt::format("path maxDepth={} nee={} mis={} rrDepth={}{}{}{}", integrator.max_depth, integrator.nee,
                     integrator.mis, integrator.rr_depth, tree, hidden, passes);
}

namespace {

void add_aovs(const Scene& scene, const std::vector<Aov>& aovs, FilmHeader& header) {
  for (const Aov aov : complete(aovs))
    header.aovs.push_back({aov, film_exponent(scene, aov_view(view_of(scene), aov))});
}

}  // namespace

FilmHeader film_identity(const Scene& scene, std::uint32_t seed) {
  FilmHeader header{.width = scene.camera.width,
                    .height = scene.camera.height,
                    .exponent = film_exponent(scene),
                    .metadata = {{"software", "Etendue"},
                                 {"version", version()},
                                 {"scene", scene.name},
                                 {"sceneHash", fmt::format("{:016x}", scene_hash(scene))},
                                 {"seed", std::to_string(seed)},
                                 {"integrator", integrator_text(scene)}}};
  add_aovs(scene, scene.aovs, header);
  if (!scene.approximations.empty()) {
    constexpr std::size_t kMost = 20;
    std::string list;
    for (std::size_t i = 0; i < std::min(scene.approximations.size(), kMost); ++i)
      list += (i > 0 ? "; " : "") + text::printable(scene.approximations[i], 200);
    if (scene.approximations.size() > kMost) list += fmt::format("; {} more", scene.approximations.size() - kMost);
    header.metadata["approximated"] = list;
  }
  if (scene.sampler.type == Sampler::Type::sobol)
    header.metadata["sampler"] = fmt::format("sobol setSize={}", scene.sampler.set_size());
  return header;
}

FilmHeader film_identity(const Scene& scene, std::uint32_t seed, const std::vector<Aov>& aovs) {
  for (const Aov aov : aovs) {
    const std::string complaint = aov_complaint(scene.integrator, aov);
    if (!complaint.empty()) throw Error(ErrorKind::usage, fmt::format("{}: {}.", scene.name, complaint));
  }
  FilmHeader header = film_identity(scene, seed);
  header.aovs.clear();
  add_aovs(scene, aovs, header);
  return header;
}

AovPlan aov_plan(const Scene& scene, std::uint32_t seed, const FilmHeader& identity) {
  return {view_of(scene), RenderSettings{.seed = seed}, identity.aovs};
}

SampleRange whole_sets(std::uint32_t paths, const Sampler& sampler) {
  const std::uint64_t sets = sampler.sets_of(paths);
  const std::uint64_t rounded = sets * sampler.set_size();
  if (rounded > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorKind::usage, fmt::format("{} samples per pixel are {} in whole sets of {}; there may be 2^32 - 1.",
                                              paths, rounded, sampler.set_size()));
  }
  return {0, static_cast<std::uint32_t>(sets)};
}

}  // namespace etendue
