#pragma once
/// A render that can be split into pieces: what is requested, what is done, and its film.

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

  /// Continues a film. Throws Error(file) if `film` belongs to another render and Error(usage) if it holds samples that
  /// were not requested. `name` is for messages.
  void resume(FilmFile film, const std::string& name);

  /// Renders the requested samples that are missing, up to `target` samples in total, or until `go_on` (called with the
  /// pixel samples of this call) returns false. Whatever it throws, the state stays valid and holds every delivered
  /// sample.
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
