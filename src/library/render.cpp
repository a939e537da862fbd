#include "etendue/render.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/core.h>

#include "core/errors.h"
#include "scene/invariants.h"

namespace etendue {
namespace {

/// The film samples of a request.
SampleRange wanted_samples(const Scene& scene, const RenderRequest& request) {
  const std::uint32_t paths = request.samples > 0 ? request.samples : scene.sampler.sample_count;
  const std::uint32_t set = scene.sampler.set_size();
  if (request.first % set != 0)
    throw Error(ErrorKind::usage, fmt::format("Sample {} is within a set of the sobol sampler, whose sets have {} "
                                              "samples; begin with a multiple of {}.",
                                              request.first, set, set));
  if (paths > std::numeric_limits<std::uint32_t>::max() - request.first)
    throw Error(ErrorKind::usage,
                fmt::format("{} samples from {} on end beyond 2^32 - 1, the last one.", paths, request.first));
  return {request.first / set, whole_sets(request.first + paths, scene.sampler).end};
}

FilmHeader identity_of(const Scene& scene, const RenderRequest& request) {
  return request.aovs ? film_identity(scene, request.seed, *request.aovs) : film_identity(scene, request.seed);
}

/// The job of a request, including the samples of the film that it continues.
RenderJob job_of(const FilmHeader& identity, const SampleRange& wanted, std::optional<FilmFile> start) {
  RenderJob job(identity, {{wanted.begin, wanted.end}});
  if (start) job.resume(*std::move(start), "the film to go on from");
  return job;
}

/// Opens the devices of a request.
DeviceTeam open_team(const SharedScene& shared, const RenderRequest& request, const FilmHeader& identity) {
  std::vector<OpenRenderer> open;
  for (const RendererFactory& factory : renderer_factories(request.devices))
    open.push_back(
        [factory, shared, settings = RenderSettings{.seed = request.seed}] { return factory(shared, settings); });
  return DeviceTeam(std::move(open), aov_plan(shared.scene(), request.seed, identity));
}

}  // namespace

struct ProgressiveRender::State {
  State(const SharedScene& shared, RenderRequest asked)
      : request(std::move(asked)),
        set_size(shared.scene().sampler.set_size()),
        identity(identity_of(shared.scene(), request)),
        job(job_of(identity, wanted_samples(shared.scene(), request), std::exchange(request.start, std::nullopt))),
        checkpoint(request.checkpoint, job),
        team(open_team(shared, request, identity)) {}

  RenderRequest request;
  std::uint32_t set_size;
  FilmHeader identity;
  RenderJob job;
  Checkpoint checkpoint;
  DeviceTeam team;
};

ProgressiveRender::ProgressiveRender(const SharedScene& scene, RenderRequest request) {
  require_invariants(scene.scene());
  state_ = std::make_unique<State>(scene, std::move(request));
}

ProgressiveRender::~ProgressiveRender() = default;

SessionEnd ProgressiveRender::advance(std::uint32_t samples) {
  State& state = *state_;
  SessionOptions options = state.request.session;
  options.set_size = state.set_size;
  options.most_samples = (std::uint64_t{samples} + state.set_size - 1) / state.set_size;
  const SessionEnd end = Session(state.job, state.checkpoint, options, state.request.hooks).run(state.team);
  state.checkpoint.save();
  return end;
}

SessionEnd ProgressiveRender::finish() {
  return advance(std::numeric_limits<std::uint32_t>::max());
}

const FilmFile& ProgressiveRender::film() const {
  return state_->job.state();
}

std::uint64_t ProgressiveRender::done() const {
  return state_->job.done() * state_->set_size;
}

std::uint64_t ProgressiveRender::total() const {
  return state_->job.total() * state_->set_size;
}

FilmFile render(const SharedScene& scene, const RenderRequest& request) {
  ProgressiveRender render(scene, request);
  render.finish();
  return render.film();
}

}  // namespace etendue
