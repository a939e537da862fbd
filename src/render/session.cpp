#include "render/session.h"

#include <algorithm>

#include <fmt/core.h>

#include "core/errors.h"
#include "render/stopping.h"

namespace etendue {
namespace {

// Samples are read back from the devices after at most this time, which bounds what the loss of a device costs.
constexpr std::chrono::seconds kLongestRound{60};

}  // namespace

const char* to_text(SessionEnd end) {
  switch (end) {
    case SessionEnd::complete:
      return "complete";
    case SessionEnd::time:
      return "time";
    case SessionEnd::error:
      return "error";
    case SessionEnd::interrupted:
      return "interrupted";
  }
  return "";
}

Session::Session(RenderJob& job, Checkpoint& checkpoint, const SessionOptions& options, SessionHooks hooks)
    : job_(job), checkpoint_(checkpoint), options_(options), hooks_(std::move(hooks)) {}

SessionEnd Session::run(DeviceTeam& team) {
  try {
    return run_rounds(team);
  } catch (...) {
    try_checkpoint();
    throw;
  }
}

SessionEnd Session::run_rounds(DeviceTeam& team) {
  const auto between_saves =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.checkpoint_seconds));
  const std::uint64_t all = std::min(job_.total(), options_.most_samples);
  while (job_.done() < all) {
    if (stop_asked()) return SessionEnd::interrupted;
    if (good_enough()) return SessionEnd::error;
    if (job_.done() > 0 && time_is_up()) return SessionEnd::time;

    round_base_ = job_.done() * job_.pixels();
    last_pass_ = Clock::now();
    round_end_ = last_pass_ + kLongestRound;
    if (checkpoint_.is_wanted()) round_end_ = std::min(round_end_, last_save_ + between_saves);
    const std::uint64_t target =
        options_.max_error ? next_error_check(job_.done(), first_error_check(options_.set_size)) : all;
    job_.advance(team, std::min(target, all), [this](std::uint64_t done) { return go_on(done); });

    if (picture_asked() && job_.done() > 0) hooks_.write_picture();
    if (Clock::now() - last_save_ >= between_saves) try_checkpoint();
  }
  return SessionEnd::complete;
}

bool Session::go_on(std::uint64_t done) {
  const auto now = Clock::now();
  pass_time_ = now - last_pass_;
  last_pass_ = now;
  if (hooks_.progress) hooks_.progress((round_base_ + done) * options_.set_size);
  return !stop_asked() && !picture_asked() && now < round_end_ && !time_is_up();
}

bool Session::stop_asked() const {
  return hooks_.stop_asked && hooks_.stop_asked();
}

bool Session::picture_asked() const {
  return hooks_.picture_asked && hooks_.picture_asked();
}

bool Session::time_is_up() const {
  if (!options_.time_seconds) return false;
  const std::chrono::duration<double> used = Clock::now() - options_.start;
  return (used + pass_time_).count() > *options_.time_seconds;  // the next pass would end too late
}

bool Session::good_enough() const {
  return options_.max_error && is_error_check(job_.done(), first_error_check(options_.set_size)) &&
         stopping_error(job_.state().film) <= *options_.max_error;
}

void Session::try_checkpoint() {
  try {
    checkpoint_.save();
    checkpoint_fails_ = false;
  } catch (const Error& error) {
    // Reported once, not every minute until there is space again.
    if (hooks_.warn && !checkpoint_fails_) hooks_.warn(fmt::format("{}. The last checkpoint is kept.", error.what()));
    checkpoint_fails_ = true;
  }
  last_save_ = Clock::now();
}

}  // namespace etendue
