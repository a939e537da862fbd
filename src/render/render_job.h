#pragma once
/// A render that can be cut into pieces: what is wanted, what is done, and the film of it.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "image/film_file.h"
#include "render/device_team.h"

namespace etendue {

class RenderJob {
 public:
  /// `identity`: size, exponent and metadata of this render, without samples.
  RenderJob(const FilmHeader& identity, SampleRanges wanted);

  /// Goes on from a film. Throws Error(file) when `film` belongs to another render and Error(usage) when it holds
  /// samples that are not wanted. `name` is for messages.
  void resume(FilmFile film, const std::string& name);

  /// Renders what is wanted and not done, up to `target` samples in all, or until `go_on` (given the pixel samples of
  /// this call) returns false. Whatever it throws, the state stays whole and holds every sample that was delivered.
  void advance(DeviceTeam& team, std::uint64_t target, const std::function<bool(std::uint64_t done)>& go_on);

  std::uint64_t done() const { return sample_count(state_.samples); }  ///< sample indices
  std::uint64_t total() const { return sample_count(wanted_); }
  std::uint64_t pixels() const { return state_.film.pixels().size(); }
  const FilmHeader& identity() const { return identity_; }  ///< without samples
  const SampleRanges& wanted() const { return wanted_; }
  const FilmFile& state() const { return state_; }
  /// The first 64 rejected samples of this session.
  const std::vector<RejectedSample>& rejected() const { return rejected_; }

 private:
  void add(const FinishedSamples& samples);

  FilmHeader identity_;
  SampleRanges wanted_;
  FilmFile state_;
  std::vector<RejectedSample> rejected_;
};

}  // namespace etendue
