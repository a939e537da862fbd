#include "etendue/render.h"

#include "scene/invariants.h"

namespace etendue {

FilmFile render(const SharedScene& shared, const RenderRequest& request) {
  const Scene& scene = shared.scene();
  require_invariants(scene);
  const std::uint32_t paths = request.samples > 0 ? request.samples : scene.sampler.sample_count;
  const SampleRange wanted = whole_sets(paths, scene.sampler);
  const FilmHeader identity = film_identity(scene, request.seed);
  RenderJob job(identity, {{wanted.begin, wanted.end}});
  if (request.start) job.resume(*request.start, "the film to go on from");
  Checkpoint checkpoint(request.checkpoint, job);

  std::vector<OpenRenderer> open;
  for (const RendererFactory& factory : renderer_factories(request.devices))
    open.push_back(
        [factory, shared, settings = RenderSettings{.seed = request.seed}] { return factory(shared, settings); });
  DeviceTeam team(std::move(open), aov_plan(scene, request.seed, identity));
  SessionOptions options = request.session;
  options.set_size = scene.sampler.set_size();
  Session(job, checkpoint, options, request.hooks).run(team);
  checkpoint.save();
  return job.state();
}

}  // namespace etendue
