#include "cli/render_session.h"

#include <algorithm>
#include <filesystem>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/log.h"
#include "image/decode.h"
#include "image/files.h"
#include "render/stopping.h"

namespace etendue::cli {
namespace {

// After this time at most, samples are brought home from the devices: it bounds what the loss of a device costs.
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

Session::Session(RenderJob& job, const SessionOptions& options)
    : job_(job),
      options_(options),
      signals_(options.quiet),
      line_(options.quiet, job.done() * job.pixels() * options.set_size,
            job.total() * job.pixels() * options.set_size) {}

SessionEnd Session::run(DeviceTeam& team) {
  try {
    const SessionEnd end = run_rounds(team);
    line_.finish();
    return end;
  } catch (const Error& error) {
    line_.finish();
    if (error.code() != ExitCode::device_lost) throw;
    try {
      save_checkpoint();
    } catch (const Error& second) {
      log::error(second.what());
    }
    throw;
  }
}

SessionEnd Session::run_rounds(DeviceTeam& team) {
  const auto between_saves =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(options_.checkpoint_seconds));
  while (job_.done() < job_.total()) {
    if (signals_.stop_asked()) return SessionEnd::interrupted;
    if (good_enough()) return SessionEnd::error;
    if (job_.done() > 0 && time_is_up()) return SessionEnd::time;

    round_base_ = job_.done() * job_.pixels();
    last_pass_ = Clock::now();
    round_end_ = last_pass_ + kLongestRound;
    if (!options_.checkpoint.empty()) round_end_ = std::min(round_end_, last_save_ + between_saves);
    const std::uint64_t target =
        options_.max_error ? next_error_check(job_.done(), first_error_check(options_.set_size)) : job_.total();
    job_.advance(team, target, [this](std::uint64_t done) { return go_on(done); });

    if (signals_.take_image_request() && job_.done() > 0) write_outputs();
    if (!options_.checkpoint.empty() && Clock::now() - last_save_ >= between_saves) save_checkpoint();
  }
  return SessionEnd::complete;
}

bool Session::go_on(std::uint64_t done) {
  const auto now = Clock::now();
  pass_time_ = now - last_pass_;
  last_pass_ = now;
  line_.update((round_base_ + done) * options_.set_size);
  return !signals_.stop_asked() && !signals_.image_asked() && now < round_end_ && !time_is_up();
}

bool Session::time_is_up() const {
  if (!options_.time_seconds) return false;
  const std::chrono::duration<double> used = Clock::now() - options_.start;
  return (used + pass_time_).count() > *options_.time_seconds;  // the next pass would end too late
}

bool Session::good_enough() const {
  return options_.max_error && is_error_check(job_.done(), first_error_check(options_.set_size)) &&
         relative_standard_error(job_.state().film) <= *options_.max_error;
}

void Session::save_checkpoint() {
  last_save_ = Clock::now();
  if (options_.checkpoint.empty() || job_.done() == saved_) return;
  write_film(options_.checkpoint, job_.state());
  saved_ = job_.done();
}

void Session::write_outputs() const {
  for (const std::string& path : options_.outputs) write_output(path, job_.state(), options_.film);
}

void check_writable(const std::string& path) {
  const AtomicFile probe(path);
}

void check_checkpoint(const std::string& path) {
  check_writable(path);
  if (!std::filesystem::exists(path)) return;
  const std::vector<std::byte> head = read_file(path, 4);
  if (head.empty() || is_exr(head)) return;
  throw Error(ExitCode::usage,
              fmt::format("'--checkpoint {}' would replace a file that is no film; give another name.", path));
}

void write_output(const std::string& path, const FilmFile& film, bool as_film) {
  if (path.ends_with(".exr") && as_film) {
    write_film(path, film);
    return;
  }
  const Image image = image_from_film(film.film, film_metadata(film));
  if (path.ends_with(".png")) {
    write_png(path, image);
  } else {
    write_exr(path, image);
  }
}

void check_output_name(const std::string& path) {
  if (path.ends_with(".exr") || path.ends_with(".png")) return;
  throw Error(ExitCode::usage,
              fmt::format("'-o {}' ends neither in .exr nor in .png, the two formats that are written.", path));
}

}  // namespace etendue::cli
