#include "render/device_team.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <thread>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/log.h"

namespace etendue {
namespace {

using Clock = std::chrono::steady_clock;

// Duration of the work that one of several devices takes from the queue at a time. Long enough that reading the film
// back costs almost nothing.
constexpr double kChunkSeconds = 5.0;
constexpr std::uint32_t kFirstChunk = 4;  // sample indices, before the first measurement

// A driver that has just reset its device may need some time.
constexpr std::chrono::milliseconds kFirstPause{250};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string without_full_stop(std::string sentence) {
  if (sentence.ends_with('.')) sentence.pop_back();
  return sentence;
}

}  // namespace

/// The state shared by the members during one call of render.
struct DeviceTeam::Run {
  SampleQueue& queue;
  const std::function<void(const FinishedSamples&)>& deliver;
  const std::function<bool(std::uint64_t done)>& go_on;
  std::mutex mutex;  ///< guards everything below, every Member::in_flight and the calls of both functions
  bool stopped = false;
  std::uint64_t delivered = 0;  ///< pixel samples
  std::exception_ptr failure;   ///< the first error that ends the run
  std::exception_ptr loss;      ///< the last device lost for good

  bool is_stopped() {
    const std::lock_guard lock(mutex);
    return stopped;
  }
};

DeviceTeam::DeviceTeam(std::vector<OpenRenderer> open, AovPlan aovs) : plan_(std::move(aovs)) {
  for (OpenRenderer& function : open) {
    Member& member = members_.emplace_back();
    member.open = std::move(function);
    try {
      member.renderer = member.open();
    } catch (const DeviceLost& error) {
      open_afresh(member, error.what());
    }
  }
}

std::vector<Renderer*> DeviceTeam::renderers() const {
  std::vector<Renderer*> all;
  for (const Member& member : members_) {
    if (member.renderer) all.push_back(member.renderer.get());
  }
  return all;
}

void DeviceTeam::look_at(AovPlan plan) {
  change(std::move(plan), [this](Renderer& renderer) { renderer.set_view(plan_.view, plan_.settings); });
}

void DeviceTeam::show(const SharedScene& scene, std::vector<OpenRenderer> open, AovPlan plan) {
  for (std::size_t i = 0; i < members_.size(); ++i) members_[i].open = std::move(open.at(i));
  change(std::move(plan), [&](Renderer& renderer) { renderer.set_scene(scene, plan_.settings); });
}

void DeviceTeam::change(AovPlan plan, const std::function<void(Renderer&)>& tell) {
  plan_ = std::move(plan);
  for (Member& member : members_) {
    member.film = {};
    member.aovs.clear();
    if (!member.renderer) continue;
    try {
      tell(*member.renderer);
    } catch (const DeviceLost& error) {
      open_afresh(member, error.what());
    }
  }
}

// Throws DeviceLost if the device has been lost too often.
void DeviceTeam::open_afresh(Member& member, std::string reason) {
  member.renderer.reset();
  while (member.failures < kRetries) {
    log::warning(fmt::format("{} Reopening the device, attempt {} of {}.", reason, member.failures + 1, kRetries));
    std::this_thread::sleep_for(kFirstPause * (1 << member.failures));
    ++member.failures;
    try {
      member.renderer = member.open();
      return;
    } catch (const DeviceHung&) {
      throw;
    } catch (const Error& error) {
      reason = error.what();  // a device that fell off its bus is not found; this also counts as a loss
    }
  }
  throw DeviceLost(fmt::format("{}; {} reopened devices were lost as well.", without_full_stop(reason), kRetries));
}

std::uint32_t DeviceTeam::chunk_size(const Member& member, const SampleQueue& queue) const {
  if (members_.size() == 1 && plan_.aovs.empty()) return ~0u;
  if (member.samples_per_second == 0) return kFirstChunk;
  // At most a share of the remaining samples, so that all devices finish together.
  const double share = static_cast<double>(queue.left()) / (2.0 * static_cast<double>(members_.size()));
  // A single device with AOVs also takes chunks, because it cannot be stopped while it renders them.
  return static_cast<std::uint32_t>(std::clamp(std::min(member.samples_per_second * kChunkSeconds, share), 1.0, 1e9));
}

// Returns the finished and delivered samples, the first part of the chunk.
SampleRange DeviceTeam::render_chunk(Member& member, Run& run, SampleRange chunk) {
  const auto start = Clock::now();
  std::vector<RejectedSample> rejected;
  std::fill(member.film.pixels().begin(), member.film.pixels().end(), FilmPixel{});
  const auto after_pass = [&](std::uint64_t done, std::uint64_t) {
    const std::lock_guard lock(run.mutex);
    member.in_flight = done;
    std::uint64_t all = run.delivered;
    for (const Member& m : members_) all += m.in_flight;
    if (!run.stopped && !run.go_on(all)) run.stopped = true;
    return !run.stopped;
  };
  const SampleRange finished{chunk.begin, member.renderer->render(chunk, member.film, after_pass, rejected)};
  if (finished.count() > 0) render_aovs(member, finished);
  member.failures = 0;
  member.samples_per_second = finished.count() / std::max(seconds_since(start), 1e-6);
  const std::lock_guard lock(run.mutex);
  member.in_flight = 0;
  if (finished.count() == 0) return finished;
  run.delivered += std::uint64_t{finished.count()} * member.film.pixels().size();
  run.deliver({finished, &member.film, &member.aovs, member.renderer.get(), &rejected});
  return finished;
}

// Afterwards the renderer is set back to the picture's view.
void DeviceTeam::render_aovs(Member& member, SampleRange samples) {
  if (plan_.aovs.empty()) return;
  for (AovFilm& aov : member.aovs) {
    std::ranges::fill(aov.film.pixels(), FilmPixel{});
    const bool first = traits(aov.aov).mean == AovMean::first;
    const SampleRange range{samples.begin, first ? samples.begin + 1 : samples.end};
    std::vector<RejectedSample> rejected;  // the film counts them
    member.renderer->set_view(aov_view(plan_.view, aov.aov), plan_.settings);
    member.renderer->render(range, aov.film, {}, rejected);
  }
  member.renderer->set_view(plan_.view, plan_.settings);
}

void DeviceTeam::work(Member& member, Run& run) {
  std::optional<SampleRange> chunk;
  try {
    while (!run.is_stopped() && (chunk = run.queue.take(chunk_size(member, run.queue)))) {
      try {
        chunk->begin = render_chunk(member, run, *chunk).end;
        run.queue.give_back(*chunk);
      } catch (const DeviceLost& error) {
        run.queue.give_back(*chunk);
        chunk.reset();
        {
          const std::lock_guard lock(run.mutex);
          member.in_flight = 0;
        }
        open_afresh(member, error.what());
      }
      chunk.reset();
    }
  } catch (const DeviceLost& error) {
    const std::lock_guard lock(run.mutex);
    run.loss = std::current_exception();
    if (members_.size() > 1) log::warning(fmt::format("{} The other devices continue without it.", error.what()));
  } catch (...) {
    const std::lock_guard lock(run.mutex);
    if (chunk) run.queue.give_back(*chunk);
    if (!run.failure) run.failure = std::current_exception();
    run.stopped = true;
  }
}

void DeviceTeam::render(SampleQueue& queue, std::uint32_t width, std::uint32_t height, int film_exponent,
                        const std::function<void(const FinishedSamples&)>& deliver,
                        const std::function<bool(std::uint64_t done)>& go_on) {
  Run run{.queue = queue, .deliver = deliver, .go_on = go_on};
  std::vector<Member*> present;
  for (Member& member : members_) {
    if (!member.renderer) continue;
    member.in_flight = 0;
    if (member.film.pixels().empty()) {
      member.film = Film(width, height, film_exponent);
      member.aovs = empty_aovs({.width = width, .height = height, .aovs = plan_.aovs});
    }
    present.push_back(&member);
  }
  if (!present.empty()) {
    // Starts only when all are ready, because each thread sums the samples in flight of all members.
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; i < present.size(); ++i)
      threads.emplace_back([this, member = present[i], &run] { work(*member, run); });
    work(*present.front(), run);  // the calling thread works too
  }
  if (run.failure) std::rethrow_exception(run.failure);
  if (renderers().empty()) std::rethrow_exception(run.loss);
}

}  // namespace etendue
