#include "view/preview.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/log.h"
#include "render/stopping.h"
#include "scene/film_unit.h"
#include "scene/invariants.h"
#include "scene/light_sources.h"
#include "scene/material_numbers.h"
#include "view/snapshot.h"

namespace etendue::view {
namespace {

constexpr double kFirstPictureSeconds = 0.05;  // rendering time of a picture while the camera moves
// Length of a round, which a change may have to wait for. Fetching the film costs as much as a sample, so rounds grow
// while nothing changes.
constexpr double kShortestRound = 0.25, kLongestRound = 0.7, kRoundShare = 0.15;
constexpr double kErrorShare = 0.1;         // largest share of the time spent on the error of the whole picture
constexpr double kFullAtOnceSeconds = 0.2;  // a full picture within this time needs no coarse one before it
constexpr std::uint32_t kCoarsest = 16;
constexpr std::chrono::milliseconds kStillMoving{400};  // how long a move that announced more counts as going on
constexpr std::chrono::seconds kWatched{15};            // longer than a page waits for an answer

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// `set` gets the name and the value of each number that changes; `own` are those of the file.
template <typename Set>
void change_numbers(const std::vector<MaterialNumber>& own, const NumberChange& change, const char* owner,
                    const Set& set) {
  const bool all = change.name.empty() && !change.value;
  bool found = all;
  for (const MaterialNumber& number : own) {
    if (!all && number.name != change.name) continue;
    if (is_map(number) && !all)
      throw Error(ErrorKind::usage,
                  fmt::format("'{}' is a texture of directions; change that in the scene file.", change.name));
    if (!is_map(number)) set(number.name, change.value.value_or(number.value));
    found = true;
  }
  if (!found) throw Error(ErrorKind::usage, fmt::format("The {} has no number '{}'.", owner, change.name));
}

std::uint32_t divided(std::uint32_t pixels, std::uint32_t scale) {
  return std::max(1u, (pixels + scale - 1) / scale);
}

}  // namespace

/// Everything replaced by a reload.
struct Preview::Opened {
  Opened(std::shared_ptr<const Scene> read, SharedScene same, std::unique_ptr<Renderer> of_it)
      : scene(std::move(read)),
        shared(std::move(same)),
        renderer(std::move(of_it)),
        palette{scene, std::make_shared<const std::vector<Material>>(scene->materials),
                std::make_shared<const LightSources>(light_sources_of(*scene))},
        bounds(bounds_of(*scene)),
        own_pose(pose_of(scene->camera, bounds)),
        radiance(radiance_exponent(*scene)) {}

  std::shared_ptr<const Scene> scene;
  SharedScene shared;
  std::unique_ptr<Renderer> renderer;
  Palette palette;  // as rendered
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
  questions_.clear();  // their promises are broken, so those who wait get an exception
  wake_.notify_all();
  changed_.notify_all();
}

State Preview::wait(std::uint64_t version, const Looked& looked, std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  looked_at_ = Clock::now();
  // Pictures finished before have no error yet.
  if (looked.error && looked_at_ - error_wanted_ > kWatched && state_.picture > 0)
    edits_["error"] = [this] { go_on(); };
  if (looked.error) error_wanted_ = looked_at_;
  if (looked.aov) layers_wanted_[*looked.aov] = looked_at_;
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
    if (move.aperture) aperture_.radius = *move.aperture;
    if (move.focus) aperture_.focus_distance = *move.focus;
    moved_ = true;
    mover_ = move.mover;
    moving_until_ = move.going_on ? Clock::now() + kStillMoving : Clock::time_point{};
    restart();
  });
}

void Preview::reset_camera() {
  edit("camera", [this] {
    moving_until_ = {};
    take_own_camera();
    restart();
  });
}

void Preview::take_own_camera() {
  moved_ = false;
  mover_ = 0;
  if (!opened_) return;
  pose_ = opened_->own_pose;
  fov_ = opened_->scene->camera.fov;
  aperture_ = opened_->scene->camera.aperture;
}

void Preview::set_samples(std::uint32_t samples) {
  edit("samples", [this, samples] {
    samples_ = samples;
    go_on();
  });
}

void Preview::set_crop(const std::optional<Crop>& crop) {
  edit("crop", [this, crop] {
    crop_.reset();
    if (crop && opened_) {
      const Camera& film = opened_->scene->camera;
      Crop cut = *crop;
      cut.x = std::min(cut.x, film.width - 1);
      cut.y = std::min(cut.y, film.height - 1);
      cut.width = std::clamp(cut.width, 1u, film.width - cut.x);
      cut.height = std::clamp(cut.height, 1u, film.height - cut.y);
      if (cut.width < film.width || cut.height < film.height) crop_ = cut;
    }
    restart();
  });
}

void Preview::change(const IntegratorChange& change) {
  // One edit per parameter: a later change of one must not replace a pending change of another.
  const auto set = [this](const char* kind, auto Integrator::*parameter, const auto& value) {
    if (!value) return;
    edit(kind, [this, parameter, to = *value] {
      integrator_.*parameter = to;
      restart();
    });
  };
  set("integrator.maxDepth", &Integrator::max_depth, change.max_depth);
  set("integrator.rrDepth", &Integrator::rr_depth, change.rr_depth);
  set("integrator.nee", &Integrator::nee, change.nee);
  set("integrator.mis", &Integrator::mis, change.mis);
}

void Preview::change(const NumberChange& change) {
  {
    const std::lock_guard lock(mutex_);
    if (!palette_.scene) throw Error(ErrorKind::usage, "There is no scene yet.");
    if (change.row >= palette_.materials->size())
      throw Error(ErrorKind::usage,
                  fmt::format("There is no material {}; the scene has {}.", change.row, palette_.materials->size()));
    std::vector<Material> materials = *palette_.materials;
    change_numbers(numbers_of(palette_.scene->materials[change.row]), change, "material",
                   [&](const std::string& name, const glm::dvec3& to) { set_number(materials[change.row], name, to); });
    Diagnostics diagnostics;
    check_materials(materials, diagnostics);
    diagnostics.throw_first_error();
    palette_.materials = std::make_shared<const std::vector<Material>>(std::move(materials));
  }
  edit("numbers", [this, going_on = change.going_on] { take_numbers(going_on); });
}

void Preview::change_light(const NumberChange& change) {
  {
    const std::lock_guard lock(mutex_);
    if (!palette_.scene) throw Error(ErrorKind::usage, "There is no scene yet.");
    if (change.row >= count_of(*palette_.lights))
      throw Error(ErrorKind::usage,
                  fmt::format("There is no light {}; the scene has {}.", change.row, count_of(*palette_.lights)));
    LightSources lights = *palette_.lights;
    change_numbers(numbers_of(light_sources_of(*palette_.scene), change.row), change, "light",
                   [&](const std::string& name, const glm::dvec3& to) { set_number(lights, change.row, name, to); });
    Diagnostics diagnostics;
    check_lights(lights, diagnostics);
    diagnostics.throw_first_error();
    palette_.lights = std::make_shared<const LightSources>(std::move(lights));
  }
  edit("numbers", [this, going_on = change.going_on] { take_numbers(going_on); });
}

Palette Preview::palette() const {
  const std::lock_guard lock(mutex_);
  return palette_;
}

// If a surface becomes anisotropic or ceases to be, the tables of directions change: then the scene is compiled again,
// for the same device and kernels.
void Preview::take_numbers(bool going_on) {
  if (!opened_) return;
  const Palette wanted = palette();
  const bool materials = wanted.materials != opened_->palette.materials;
  const bool lights = wanted.lights != opened_->palette.lights;
  if (!materials && !lights) return;
  const bool same_tables = exchange_complaint(*opened_->palette.materials, *wanted.materials).empty();
  if (same_tables && !lights) {
    opened_->renderer->set_materials(*wanted.materials);
  } else {
    auto scene = std::make_shared<Scene>(*wanted.scene);
    scene->materials = *wanted.materials;
    set_light_sources(*scene, *wanted.lights);
    if (same_tables)
      set_lights(std::move(scene));
    else
      opened_ = open(std::move(scene));
  }
  opened_->palette = wanted;
  {
    const std::lock_guard lock(mutex_);
    state_.materials += materials ? 1 : 0;
    state_.lights += lights ? 1 : 0;
  }
  moving_until_ = going_on ? Clock::now() + kStillMoving : Clock::time_point{};
  restart();
}

// The shapes and their tree stay as they are.
void Preview::set_lights(std::shared_ptr<const Scene> scene) {
  SharedScene shared(scene);
  try {
    opened_->renderer->set_lights(shared, {.seed = options_.seed});
  } catch (...) {
    open_again();
    throw;
  }
  opened_->radiance = radiance_exponent(*scene);
  opened_->scene = std::move(scene);
  opened_->shared = std::move(shared);
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
                         .materials = *opened_->palette.materials,
                         .lights = *opened_->palette.lights,
                         .camera = film_camera(),
                         .integrator = integrator_,
                         .seed = options_.seed,
                         .device = opened_->renderer->device_name(),
                         .driver = opened_->renderer->driver_name(),
                         .samples = done_},
                        film_, extension, display);
}

// The loop of the rendering thread. After an error of a device or a scene, it reports the error and waits for a change.
void Preview::run() {
  edit("reload", [this] { load(); });
  for (;;) {
    try {
      if (!run_edits(!has_work())) return;
      answer_questions();
      if (has_work()) work();
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::lost) opened_.reset();  // the next reload opens it again
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
      // Wakes now and then to see whether somebody looks again, or the camera has come to rest.
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
  if ((is_done() || (scale_ == 1 && done_ > 0 && paused_)) && wanted_layers().empty()) return false;
  const std::lock_guard lock(mutex_);
  if (state_.phase == Phase::stopped) return false;
  if (Clock::now() - looked_at_ <= options_.unwatched) return true;
  state_.phase = Phase::resting;  // the next one who looks makes it continue
  return false;
}

std::unique_ptr<Renderer> Preview::open_renderer_of(const SharedScene& scene) const {
  const RenderSettings settings{.seed = options_.seed};
  return options_.open ? options_.open(scene, settings) : open_renderer(scene, options_.device, settings);
}

// If a scene is open already, its device and kernels are kept.
std::unique_ptr<Preview::Opened> Preview::open(std::shared_ptr<const Scene> scene) {
  const RenderSettings settings{.seed = options_.seed};
  require_invariants(*scene);
  SharedScene shared(scene);
  std::unique_ptr<Renderer> renderer;
  if (!opened_) {
    renderer = open_renderer_of(shared);
  } else {
    try {
      opened_->renderer->set_scene(shared, settings);
    } catch (...) {
      open_again();
      throw;
    }
    renderer = std::move(opened_->renderer);
  }
  return std::make_unique<Opened>(std::move(scene), std::move(shared), std::move(renderer));
}

// The last good scene, with what has been changed in it, after its renderer failed to take another one.
void Preview::open_again() {
  try {
    opened_->renderer.reset();
    opened_->renderer = open_renderer_of(opened_->shared);
    opened_->renderer->set_materials(*opened_->palette.materials);
  } catch (...) {
    opened_.reset();  // the next reload begins afresh
    return;
  }
  restart();
}

void Preview::load() {
  tell(Phase::opening);
  const ReadLog log;
  try {
    auto scene = std::make_shared<const Scene>(options_.read_scene());
    auto opened = open(std::move(scene));
    // A camera that was moved stays there, unless the camera in the file has changed.
    const bool same_camera = opened_ &&
                             opened_->scene->camera.world_from_camera == opened->scene->camera.world_from_camera &&
                             opened_->scene->camera.fov == opened->scene->camera.fov;
    opened_ = std::move(opened);
    if (!moved_ || !same_camera) take_own_camera();
    integrator_ = opened_->scene->integrator;
    if (const Camera& film = opened_->scene->camera;
        crop_ && (crop_->x + crop_->width > film.width || crop_->y + crop_->height > film.height))
      crop_.reset();
    restart();
    const std::lock_guard lock(mutex_);
    files_ = log.files();
    palette_ = opened_->palette;
    ++state_.materials;
    ++state_.lights;
    ++state_.loads;
    state_.problem.clear();
    state_.scene = opened_->scene->name;
    state_.file = opened_->scene->file;
    state_.device = opened_->renderer->device_name();
    state_.driver = opened_->renderer->driver_name();
  } catch (const Error& error) {
    {
      // The files of the last good scene are watched as well: the error may be that one of them is missing.
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
  {
    const std::lock_guard lock(mutex_);
    state_.layers.clear();
  }
  if (opened_) tell(Phase::rendering);
}

Camera Preview::camera() const {
  Camera out = moved(opened_->scene->camera, opened_->own_pose, pose_);
  out.fov = fov_;
  out.aperture = aperture_;
  // A lens without an aperture is a pinhole, and vice versa.
  if (aperture_.radius == opened_->scene->camera.aperture.radius) return out;
  if (out.type == Camera::Type::perspective && aperture_.radius > 0.0) out.type = Camera::Type::thin_lens;
  if (out.type == Camera::Type::thin_lens && aperture_.radius == 0.0) out.type = Camera::Type::perspective;
  return out;
}

/// The camera of the part that is rendered: of the crop, if there is one.
Camera Preview::film_camera() const {
  Camera out = camera();
  if (!crop_) return out;
  const glm::dvec2 film(out.width, out.height);
  out.window.origin += out.window.size * (glm::dvec2(crop_->x, crop_->y) / film);
  out.window.size *= glm::dvec2(crop_->width, crop_->height) / film;
  out.width = crop_->width;
  out.height = crop_->height;
  return out;
}

View Preview::full_view() const {
  return {camera(), opened_->scene->sampler, integrator_};
}

/// The view at the present scale.
View Preview::present_view() const {
  View view = full_view();
  view.camera = film_camera();
  view.camera.width = divided(view.camera.width, scale_);
  view.camera.height = divided(view.camera.height, scale_);
  return view;
}

std::uint32_t Preview::first_scale() const {
  const Camera camera = film_camera();
  const double set = opened_->scene->sampler.set_size();
  std::uint32_t scale = 1;
  while (scale < kCoarsest && divided(camera.width, scale) * static_cast<double>(divided(camera.height, scale)) * set >
                                  kFirstPictureSeconds * rate_)
    scale *= 2;
  return scale;
}

std::uint32_t Preview::next_scale() const {
  const Camera camera = film_camera();
  const double full = static_cast<double>(camera.width) * camera.height * opened_->scene->sampler.set_size();
  return full <= kFullAtOnceSeconds * rate_ ? 1 : std::max(1u, scale_ / 2);
}

void Preview::begin(std::uint32_t scale) {
  scale_ = scale;
  const View view = present_view();
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
  // The first picture comes soon; then there are more and more samples per round.
  return std::min({static_cast<std::uint32_t>(affordable), std::max(1u, done_), std::max(1u, target_sets() - done_)});
}

void Preview::work() {
  const bool moving = Clock::now() < moving_until_;
  if (scale_ == 0) {
    begin(first_scale());
  } else if (scale_ > 1 && !moving && done_ > 0) {
    begin(next_scale());
  }
  if (scale_ == 1 && done_ > 0) add_layers();
  if (is_done() || (paused_ && scale_ == 1 && done_ > 0)) return;
  const std::uint32_t count = round_samples();
  std::vector<RejectedSample> rejected;
  const auto start = Clock::now();
  const std::uint32_t end = opened_->renderer->render(
      {done_, done_ + count}, film_, [this](std::uint64_t, std::uint64_t) { return !interrupted_; }, rejected);
  const double samples = static_cast<double>(end - done_) * static_cast<double>(film_.pixels().size()) *
                         opened_->scene->sampler.set_size();
  const double rate = samples / std::max(seconds_since(start), 1e-6);
  // The first round includes compiling a kernel, so it can only raise the rate; later, the newest one counts half.
  rate_ = scale_ > 1 && done_ == 0 ? std::max(rate_, rate) : 0.5 * (rate_ + rate);
  done_ = end;
  if (wants_picture()) publish();
}

// The AOVs that somebody looks at and that have no layer yet.
std::set<Aov> Preview::wanted_layers() {
  const std::lock_guard lock(mutex_);
  std::set<Aov> wanted;
  if (state_.phase == Phase::stopped) return wanted;
  for (const auto& [aov, when] : layers_wanted_) {
    if (Clock::now() - when < kWatched && !state_.layers.contains(traits(aov).name) &&
        aov_complaint(integrator_, aov).empty())
      wanted.insert(aov);
  }
  return wanted;
}

void Preview::add_layers() {
  const std::set<Aov> wanted = wanted_layers();
  if (wanted.empty()) return;
  for (const Aov aov : wanted) {
    if (interrupted_) break;
    add_layer(aov);
    tell(is_done() ? Phase::done : Phase::rendering);
  }
  opened_->renderer->set_view(present_view(), {.seed = options_.seed});
}

// A few samples are enough, because most AOVs have no noise.
void Preview::add_layer(Aov aov) {
  constexpr std::uint32_t kPaths = 8;
  const View view = present_view();
  std::vector<AovFilm> films;
  for (const Aov part : complete({aov})) {
    const View shown = aov_view(view, part);
    films.push_back(
        {part, Film(view.camera.width, view.camera.height, view_exponent(shown, opened_->radiance, opened_->bounds))});
    const auto sets = static_cast<std::uint32_t>(view.sampler.sets_of(kPaths));
    std::vector<RejectedSample> rejected;
    opened_->renderer->set_view(shown, {.seed = options_.seed});
    opened_->renderer->render({0, traits(part).mean == AovMean::first ? 1 : sets}, films.back().film, {}, rejected);
  }
  auto layer = std::make_shared<Layer>(packed(films, aov));
  layer->number = ++layers_made_;
  const std::lock_guard lock(mutex_);
  state_.layers[traits(aov).name] = std::move(layer);
}

SampleId Preview::id_of(std::uint32_t x, std::uint32_t y, std::uint32_t sample) const {
  if (!opened_) throw Error(ErrorKind::usage, "There is no scene yet.");
  const Camera& camera = opened_->scene->camera;
  if (x >= camera.width || y >= camera.height)
    throw Error(ErrorKind::usage, fmt::format("({}, {}) is no pixel of {}x{}; 0, 0 is at the top left.", x, y,
                                              camera.width, camera.height));
  return {y * camera.width + x, sample};
}

Point Preview::point_at(std::uint32_t x, std::uint32_t y) {
  const Subject subject = ask<Subject>([this, x, y] { return subject_of(x, y, 0); });
  // The reference does this, because the device would need another kernel.
  const std::lock_guard lock(reference_mutex_);
  Renderer& reference = reference_of(subject.palette);
  const auto value = [&](Aov aov) {
    reference.set_view(aov_view(subject.view, aov), {.seed = options_.seed});
    return glm::dvec3(reference.trace_samples(std::span(&subject.id, 1)).front().radiance);
  };
  Point point{.hit = value(Aov::hit).x > 0.0};
  if (!point.hit) return point;
  point.position = value(Aov::position);
  // Rows are numbered from 1 on, as two 16-bit halves.
  const auto number = [&](Aov aov) {
    const glm::dvec3 halves = value(aov);
    return static_cast<std::uint32_t>(halves.x + 65536.0 * halves.y) - 1;
  };
  point.material = number(Aov::material);
  const Instance& instance = subject.palette.scene->instances[number(Aov::instance)];
  point.light = instance.emitter;
  point.focus = (glm::inverse(subject.view.camera.world_from_camera) * glm::dvec4(point.position, 1.0)).z;
  return point;
}

Told Preview::explain(std::uint32_t x, std::uint32_t y, std::uint32_t sample) {
  return ask<Told>([this, x, y, sample] {
    const Subject subject = subject_of(x, y, sample);
    opened_->renderer->set_view(subject.view, {.seed = options_.seed});
    Told told{opened_->renderer->device_name(), opened_->renderer->trace_path(subject.id)};
    if (scale_ > 0) opened_->renderer->set_view(present_view(), {.seed = options_.seed});
    return told;
  });
}

Told Preview::explain_by_reference(std::uint32_t x, std::uint32_t y, std::uint32_t sample) {
  const Subject subject = ask<Subject>([this, x, y, sample] { return subject_of(x, y, sample); });
  const std::lock_guard lock(reference_mutex_);
  Renderer& reference = reference_of(subject.palette);
  reference.set_view(subject.view, {.seed = options_.seed});
  return {reference.device_name(), reference.trace_path(subject.id)};
}

Preview::Subject Preview::subject_of(std::uint32_t x, std::uint32_t y, std::uint32_t sample) const {
  const SampleId id = id_of(x, y, sample);
  return {opened_->palette, full_view(), id};
}

Renderer& Preview::reference_of(const Palette& palette) {
  if (reference_ && reference_palette_.scene == palette.scene && reference_palette_.lights == palette.lights &&
      exchange_complaint(*reference_palette_.materials, *palette.materials).empty()) {
    if (reference_palette_.materials != palette.materials) reference_->set_materials(*palette.materials);
  } else {
    reference_.reset();
    Scene scene = *palette.scene;
    scene.materials = *palette.materials;
    set_light_sources(scene, *palette.lights);
    reference_ = open_renderer(scene, {.selector = "reference"}, {.seed = options_.seed});
  }
  reference_palette_ = palette;
  return *reference_;
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
    s.integrator = integrator_;
    s.crop = crop_;
    s.full_width = crop_ ? crop_->width : s.camera.width;
    s.full_height = crop_ ? crop_->height : s.camera.height;
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
