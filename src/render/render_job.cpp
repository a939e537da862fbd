#include "render/render_job.h"

#include <algorithm>

#include <fmt/core.h>

#include "core/errors.h"
#include "image/merge.h"

namespace etendue {

RenderJob::RenderJob(const FilmHeader& identity, SampleRanges wanted)
    : identity_(identity),
      wanted_(canonical(std::move(wanted))),
      state_{Film(identity.width, identity.height, identity.exponent), identity.metadata, {}, empty_aovs(identity)} {
  identity_.samples.clear();
}

void RenderJob::resume(FilmFile film, const std::string& name) {
  check_same_render(identity_, "this render", header_of(film), name);
  if (const SampleRanges surplus = difference(film.samples, wanted_); !surplus.empty()) {
    throw Error(ErrorKind::usage, fmt::format("{}: holds the samples {}, but only {} were requested; samples cannot be "
                                              "removed again, so request them as well.",
                                              name, to_text(film.samples), to_text(wanted_)));
  }
  state_ = std::move(film);
}

void RenderJob::advance(DeviceTeam& team, std::uint64_t target, const std::function<bool(std::uint64_t done)>& go_on) {
  if (target <= done()) return;
  SampleQueue queue(first_samples(difference(wanted_, state_.samples), target - done()));
  team.render(
      queue, identity_.width, identity_.height, identity_.exponent,
      [&](const FinishedSamples& samples) { add(samples); }, go_on);
}

void RenderJob::add(const FinishedSamples& finished) {
  FilmHeader added = identity_;
  added.samples = {{finished.range.begin, finished.range.end}};
  added.metadata["device"] = finished.renderer->device_name();
  added.metadata["driver"] = finished.renderer->driver_name();
  FilmHeader both = merge_headers(header_of(state_), added);
  state_.film.merge(*finished.film);
  merge_aovs(state_.aovs, lowest_sample(state_.samples), *finished.aovs, finished.range.begin);
  state_.samples = std::move(both.samples);
  state_.metadata = std::move(both.metadata);
  for (const RejectedSample& sample : *finished.rejected) {
    if (rejected_.size() < 64) rejected_.push_back(sample);
  }
}

}  // namespace etendue
