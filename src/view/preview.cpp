#include "view/preview.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/log.h"
#include "render/stopping.h"
#include "scene/film_unit.h"
#include "view/snapshot.h"

namespace etendue::view {
namespace {

constexpr double kFirstPictureSeconds = 0.05;  // of rendering: what a picture while the camera moves may take
// What a change may have to wait for: a fetch of the film costs as much as a sample, so that rounds grow while nothing
// happens.
constexpr double kShortestRound = 0.25, kLongestRound = 0.7, kRoundShare = 0.15;
constexpr double kErrorShare = 0.1;         // of the time that may go into the error of the whole picture
constexpr double kFullAtOnceSeconds = 0.2;  // a full picture that takes no more needs no step between
constexpr std::uint32_t kCoarsest = 16;
constexpr std::chrono::milliseconds kStillMoving{400};  // after the last move that more were said to follow
constexpr std::chrono::seconds kWatched{5};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::uint32_t divided(std::uint32_t pixels, std::uint32_t scale) {
  return std::max(1u, (pixels + scale - 1) / scale);
}

}  // namespace

/// Everything that a reload replaces.
struct Preview::Opened {
  explicit Opened(std::shared_ptr<const Scene> read, const DeviceSelection& device, std::uint32_t seed)
      : scene(std::move(read)),
        shared(scene),
        renderer(open_renderer(shared, device, {.seed = seed})),
        bounds(bounds_of(*scene)),
        own_pose(pose_of(scene->camera, bounds)),
        radiance(radiance_exponent(*scene)) {}

  std::shared_ptr<const Scene> scene;
  SharedScene shared;
  std::unique_ptr<Renderer> renderer;
  Bounds bounds;
  Pose own_pose;
  int radiance;
};

Preview::Preview(PreviewOptions options)
    : options_(std::move(options)), samples_(options_.samples), thread_([this] { run(); }) {}

Preview::~Preview() {
  stop();
  thread_.join();
}

void Preview::stop() {
  const std::lock_guard lock(mutex_);
  stopping_ = true;
  interrupted_ = true;
  questions_.clear();  // breaks their promises
  wake_.notify_all();
  changed_.notify_all();
}

State Preview::wait(std::uint64_t version, bool error, std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  looked_at_ = Clock::now();
  // Pictures that were finished before carry no error yet.
  if (error && looked_at_ - error_wanted_ > kWatched && state_.picture > 0) edits_["error"] = [this] { go_on(); };
  if (error) error_wanted_ = looked_at_;
  wake_.notify_all();
  changed_.wait_for(lock, longest, [&] { return stopping_ || state_.version > version; });
  looked_at_ = Clock::now();
  return state_;
}

void Preview::edit(const std::string& kind, Edit edit) {
  const std::lock_guard lock(mutex_);
  edits_[kind] = std::move(edit);
  interrupted_ = true;
  looked_at_ = Clock::now();
  wake_.notify_all();
}

void Preview::move(const Move& move) {
  edit("camera", [this, move] {
    pose_ = move.pose;
    if (move.fov > 0.0) fov_ = move.fov;
    moved_ = true;
    mover_ = move.mover;
    moving_until_ = move.going_on ? Clock::now() + kStillMoving : Clock::time_point{};
    restart();
  });
}

void Preview::reset_camera() {
  edit("camera", [this] {
    moved_ = false;
    mover_ = 0;
    moving_until_ = {};
    if (opened_) {
      pose_ = opened_->own_pose;
      fov_ = opened_->scene->camera.fov;
    }
    restart();
  });
}

void Preview::set_samples(std::uint32_t samples) {
  edit("samples", [this, samples] {
    samples_ = samples;
    go_on();
  });
}

void Preview::set_paused(bool paused) {
  edit("paused", [this, paused] {
    paused_ = paused;
    go_on();
  });
}

void Preview::reload() {
  edit("reload", [this] { load(); });
}

FileStamps Preview::files() const {
  const std::lock_guard lock(mutex_);
  return files_;
}

template <class Result>
Result Preview::ask(std::function<Result()> question) {
  auto promise = std::make_shared<std::promise<Result>>();
  std::future<Result> result = promise->get_future();
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) throw Error(ErrorKind::interrupted, "The viewer is ending.");
    questions_.push_back([promise, question = std::move(question)] {
      try {
        promise->set_value(question());
      } catch (...) {
        promise->set_exception(std::current_exception());
      }
    });
    interrupted_ = true;
    wake_.notify_all();
  }
  return result.get();
}

std::string Preview::snapshot(const std::string& extension, const Display& display) {
  return ask<std::string>([this, extension, display] { return write_snapshot(extension, display); });
}

std::string Preview::write_snapshot(const std::string& extension, const Display& display) {
  if (!opened_ || scale_ != 1 || done_ == 0)
    throw Error(ErrorKind::usage, "The picture is still coarse; ask again when it has its full size.");
  return snapshot_bytes({.scene = *opened_->scene,
                         .camera = camera(),
                         .integrator = opened_->scene->integrator,
                         .seed = options_.seed,
                         .device = opened_->renderer->device_name(),
                         .driver = opened_->renderer->driver_name(),
                         .samples = done_},
                        film_, extension, display);
}

// What the thread does until the end. An error of a device or a scene is told and waited with until something changes.
void Preview::run() {
  edit("reload", [this] { load(); });
  for (;;) {
    try {
      if (!run_edits(!has_work())) return;
      answer_questions();
      if (has_work()) work();
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::lost) opened_.reset();  // opened afresh by the next reload
      fail(error.what());
    } catch (const std::bad_alloc&) {
      fail("The host ran out of memory; use a smaller film.");
    }
  }
}

bool Preview::run_edits(bool wait) {
  std::map<std::string, Edit> edits;
  {
    std::unique_lock lock(mutex_);
    if (wait) {
      // Now and then to see whether somebody looks again, or a camera has come to rest.
      wake_.wait_for(lock, std::chrono::milliseconds(100),
                     [&] { return stopping_ || !edits_.empty() || !questions_.empty(); });
    }
    interrupted_ = stopping_.load();
    if (stopping_) return false;
    edits.swap(edits_);
  }
  for (const auto& [kind, edit] : edits) edit();
  return true;
}

void Preview::answer_questions() {
  std::vector<std::function<void()>> questions;
  {
    const std::lock_guard lock(mutex_);
    questions.swap(questions_);
  }
  for (const auto& question : questions) question();
}

std::uint32_t Preview::target_sets() const {
  const Sampler& sampler = opened_->scene->sampler;
  return whole_sets(samples_ > 0 ? samples_ : sampler.sample_count, sampler).end;
}

bool Preview::has_work() {
  if (!opened_) return false;
  if (is_done() || (scale_ == 1 && done_ > 0 && paused_)) return false;
  const std::lock_guard lock(mutex_);
  if (state_.phase == Phase::stopped) return false;
  if (Clock::now() - looked_at_ <= options_.unwatched) return true;
  state_.phase = Phase::resting;  // whoever looks again finds it going on
  return false;
}

void Preview::load() {
  tell(Phase::opening);
  const ReadLog log;
  try {
    auto scene = std::make_shared<const Scene>(options_.read_scene());
    auto opened = std::make_unique<Opened>(std::move(scene), options_.device, options_.seed);
    // Who moved the camera keeps it there, unless the file says now that it stands elsewhere.
    const bool same_camera = opened_ &&
                             opened_->scene->camera.world_from_camera == opened->scene->camera.world_from_camera &&
                             opened_->scene->camera.fov == opened->scene->camera.fov;
    opened_ = std::move(opened);
    if (!moved_ || !same_camera) {
      moved_ = false;
      mover_ = 0;
      pose_ = opened_->own_pose;
      fov_ = opened_->scene->camera.fov;
    }
    restart();
    const std::lock_guard lock(mutex_);
    files_ = log.files();
    ++state_.loads;
    state_.problem.clear();
    state_.scene = opened_->scene->name;
    state_.file = opened_->scene->file;
    state_.device = opened_->renderer->device_name();
    state_.driver = opened_->renderer->driver_name();
  } catch (const Error& error) {
    {
      // Files of the last good scene are watched as well: the error may be that one of them is missing.
      const std::lock_guard lock(mutex_);
      for (const auto& [path, stamp] : log.files()) files_[path] = stamp;
      state_.problem = error.what();
    }
    tell(!opened_ ? Phase::stopped : is_done() ? Phase::done : Phase::rendering);
  }
}

bool Preview::is_done() const {
  return scale_ == 1 && done_ > 0 && done_ >= target_sets();
}

void Preview::go_on() {
  if (!opened_) return;
  if (scale_ > 0 && done_ > 0) publish();
  tell(is_done() ? Phase::done : Phase::rendering);
}

void Preview::restart() {
  scale_ = 0;
  if (opened_) tell(Phase::rendering);
}

Camera Preview::camera() const {
  Camera out = moved(opened_->scene->camera, opened_->own_pose, pose_);
  out.fov = fov_;
  return out;
}

std::uint32_t Preview::first_scale() const {
  const Camera& camera = opened_->scene->camera;
  const double set = opened_->scene->sampler.set_size();
  std::uint32_t scale = 1;
  while (scale < kCoarsest && divided(camera.width, scale) * static_cast<double>(divided(camera.height, scale)) * set >
                                  kFirstPictureSeconds * rate_)
    scale *= 2;
  return scale;
}

std::uint32_t Preview::next_scale() const {
  const Camera& camera = opened_->scene->camera;
  const double full = static_cast<double>(camera.width) * camera.height * opened_->scene->sampler.set_size();
  return full <= kFullAtOnceSeconds * rate_ ? 1 : std::max(1u, scale_ / 2);
}

void Preview::begin(std::uint32_t scale) {
  scale_ = scale;
  View view = view_of(*opened_->scene);
  view.camera = camera();
  view.camera.width = divided(view.camera.width, scale);
  view.camera.height = divided(view.camera.height, scale);
  opened_->renderer->set_view(view, {.seed = options_.seed});
  film_ = Film(view.camera.width, view.camera.height, view_exponent(view, opened_->radiance, opened_->bounds));
  begun_ = Clock::now();
  done_ = 0;
  published_done_ = 0;
  relative_error_ = std::numeric_limits<double>::infinity();
}

std::uint32_t Preview::round_samples() const {
  const double set = opened_->scene->sampler.set_size();
  const double each = static_cast<double>(film_.pixels().size()) * set / rate_;
  const double seconds = std::clamp(kRoundShare * seconds_since(begun_), kShortestRound, kLongestRound);
  const double affordable = std::clamp(seconds / each, 1.0, 4096.0);
  // A picture soon, then more and more samples at a time.
  return std::min({static_cast<std::uint32_t>(affordable), std::max(1u, done_), std::max(1u, target_sets() - done_)});
}

void Preview::work() {
  const bool moving = Clock::now() < moving_until_;
  if (scale_ == 0) {
    begin(first_scale());
  } else if (scale_ > 1 && !moving && done_ > 0) {
    begin(next_scale());
  }
  const std::uint32_t count = round_samples();
  std::vector<RejectedSample> rejected;
  const auto start = Clock::now();
  const std::uint32_t end = opened_->renderer->render(
      {done_, done_ + count}, film_, [this](std::uint64_t, std::uint64_t) { return !interrupted_; }, rejected);
  const double samples = static_cast<double>(end - done_) * static_cast<double>(film_.pixels().size()) *
                         opened_->scene->sampler.set_size();
  const double rate = samples / std::max(seconds_since(start), 1e-6);
  // A kernel is compiled in the first round; then the newest measurement counts half.
  rate_ = scale_ > 1 && done_ == 0 ? std::max(rate_, rate) : 0.5 * (rate_ + rate);
  done_ = end;
  if (wants_picture()) publish();
}

bool Preview::wants_picture() const {
  if (done_ == 0) return false;
  if (published_done_ == 0 || is_done() || scale_ > 1) return true;
  return seconds_since(published_) > std::max(0.2, 4.0 * publishing_seconds_);
}

void Preview::publish() {
  const auto start = Clock::now();
  bool with_error = false;
  {
    const std::lock_guard lock(mutex_);
    with_error = Clock::now() - error_wanted_ < kWatched;
  }
  const Bytes mean = packed(film_, Channel::mean);
  const Bytes error = with_error ? packed(film_, Channel::error) : nullptr;
  const std::uint32_t set = opened_->scene->sampler.set_size(), target = target_sets();
  const bool finished = is_done();
  if (done_ > 1 && (finished || relative_error_ == std::numeric_limits<double>::infinity() ||
                    seconds_since(error_known_) > error_seconds_ / kErrorShare)) {
    const auto before = Clock::now();
    relative_error_ = relative_standard_error(film_);
    error_seconds_ = seconds_since(before);
    error_known_ = Clock::now();
  }
  const double left = static_cast<double>(target - std::min(target, done_)) * set *
                      static_cast<double>(film_.pixels().size()) / std::max(rate_, 1.0);
  {
    const std::lock_guard lock(mutex_);
    State& s = state_;
    ++s.picture;
    s.width = film_.width();
    s.height = film_.height();
    s.mean = mean;
    s.error = error;
    s.samples = std::uint64_t{done_} * set;
    s.target = std::uint64_t{target} * set;
    s.samples_per_second = rate_;
    s.relative_error = relative_error_;
    s.seconds_left = scale_ > 1 ? std::numeric_limits<double>::infinity() : left;
    s.rejected = film_.rejected();
    s.phase = finished ? Phase::done : Phase::rendering;
  }
  published_ = Clock::now();
  published_done_ = done_;
  publishing_seconds_ = seconds_since(start);
  tell(finished ? Phase::done : Phase::rendering);
}

void Preview::tell(Phase phase) {
  const std::lock_guard lock(mutex_);
  State& s = state_;
  ++s.version;
  s.phase = phase == Phase::rendering && paused_ ? Phase::resting : phase;
  s.paused = paused_;
  if (opened_) {
    s.camera = camera();
    s.pose = pose_;
    s.mover = mover_;
    s.integrator = opened_->scene->integrator;
    s.full_width = s.camera.width;
    s.full_height = s.camera.height;
  }
  changed_.notify_all();
}

void Preview::fail(const std::string& sentence) {
  {
    const std::lock_guard lock(mutex_);
    state_.problem = sentence;
  }
  tell(Phase::stopped);
}

}  // namespace etendue::view
