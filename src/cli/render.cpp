#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>
#include "cli/command.h"
#include "cli/frames.h"
#include "cli/outputs.h"
#include "cli/overwrite.h"
#include "cli/progress.h"
#include "cli/render_stats.h"
#include "cli/result_files.h"
#include "cli/results.h"
#include "cli/signals.h"
#include "cli/tev_viewer.h"
#include "cli/units.h"
#include "core/json.h"
#include "core/log.h"
#include "formats/gltf/gltf_document.h"
#include "gpu/gpu_renderer.h"
#include "image/denoiser.h"
#include "render/film_identity.h"
#include "render/session.h"
#include "render/stopping.h"
#include "scene/precision.h"
#include "scene/view.h"

namespace etendue::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kPieces = "Render in pieces, stop and resume";  // a heading of --help

struct RenderArguments {
  std::string scene_file;
  SceneOptions scene;
  DeviceOption device;
  std::vector<std::string> outputs;
  SampleOptions sampling;
  std::string samples;
  std::string checkpoint, checkpoint_every, resume;
  std::string time, until_error;
  std::string aovs;
  bool alpha = false;
  bool film = false;
  bool stats = false;
  std::vector<std::string> heat_maps;  ///< .exr and .png
  std::string tev;                     ///< an address, "-" for the usual one, or empty
  DenoiseOptions denoise;
  FrameOptions frames;
  DisplayOptions display;
  OverwriteOptions overwrite;
  ResultOptions results;
};

bool uses_gpu(const RenderArguments& options) {
  return options.device.selector != "reference";
}

// A range of paths as film samples, which are whole sets.
SampleRange whole_sets(const SampleRange& paths, const Sampler& sampler) {
  const std::uint32_t size = sampler.set_size();
  if (paths.begin % size == 0 && paths.end % size == 0) return {paths.begin / size, paths.end / size};
  throw Error(
      ErrorKind::usage,
      fmt::format("'--samples {}:{}' cuts a set of the sobol sampler, whose sets have {} samples; give multiples "
                  "of {}.",
                  paths.begin, paths.end, size, size));
}

// All samples of the render, in film samples: whole sets.
SampleRange all_samples(std::uint32_t paths, const Sampler& sampler) {
  const SampleRange sets = etendue::whole_sets(paths, sampler);
  const std::uint64_t rounded = std::uint64_t{sets.end} * sampler.set_size();
  if (rounded != paths)
    log::info(fmt::format("{} samples per pixel become {}: the sobol sampler takes whole sets of {}.", paths, rounded,
                          sampler.set_size()));
  return sets;
}

// In film samples, which are sets of paths.
SampleRange wanted_samples(const RenderArguments& options, const Scene& scene) {
  if (options.samples.empty())
    return all_samples(options.sampling.spp > 0 ? options.sampling.spp : scene.sampler.sample_count, scene.sampler);
  const SampleRange range = parse_samples(options.samples);
  if (options.sampling.spp > 0 && range.end > options.sampling.spp) {
    throw Error(
        ErrorKind::usage,
        fmt::format(
            "'--samples {}' ends beyond the {} samples of '--spp'; a range of an N spp render must be inside 0:N.",
            options.samples, options.sampling.spp));
  }
  return whole_sets(range, scene.sampler);
}

std::vector<std::string> output_paths(const RenderArguments& options, const Scene& scene) {
  if (!options.outputs.empty()) return options.outputs;
  const std::string name = scene.name + (options.frames.wanted() ? "-####" : "");
  return {name + ".exr", name + ".png"};
}

/// The task of one call of the command.
struct Plan {
  SessionOptions session;
  std::vector<std::string> outputs;  ///< .exr and .png
  bool film = false;                 ///< .exr outputs are films, which can be merged and resumed
  std::optional<ViewerAddress> tev;  ///< the viewer that shows it
  std::optional<Denoiser> denoiser;
  std::vector<std::string> denoised;  ///< paths of denoised pictures, one for each output
  std::optional<std::uint32_t> frame;
  std::vector<Json> reports;  ///< of frames, for one file of --json
};

Plan make_plan(const RenderArguments& options, Clock::time_point start) {
  if (!options.checkpoint_every.empty() && options.checkpoint.empty()) {
    throw Error(ErrorKind::usage, "'--checkpoint-every' needs the file to write: add --checkpoint FILE.");
  }
  if (!options.denoise.library.empty() && !options.denoise.wanted)
    throw Error(ErrorKind::usage, "--oidn gives the library for --denoise, which is missing; add it.");
  for (const std::string& path : options.outputs) check_output_name(path);
  for (const std::string& path : options.heat_maps) check_output_name(path);
  if ((options.stats || !options.heat_maps.empty()) && !uses_gpu(options))
    throw Error(ErrorKind::usage, "--stats and --heat-map count on a Vulkan device; choose another --device.");
  if ((options.stats || !options.heat_maps.empty()) && options.device.traversal == "query")
    throw Error(ErrorKind::usage,
                "--stats and --heat-map count what rays visit in the tree, and a driver does not tell what it visits; "
                "use --traversal tree.");
  Plan plan{.session = {.start = start}, .film = options.film || !options.samples.empty()};
  SessionOptions& session = plan.session;
  if (!options.checkpoint_every.empty())
    session.checkpoint_seconds = parse_duration("--checkpoint-every", options.checkpoint_every);
  if (!options.time.empty()) session.time_seconds = parse_duration("--time", options.time);
  if (!options.tev.empty()) plan.tev = options.tev == "-" ? ViewerAddress() : parse_viewer_address(options.tev);
  if (options.denoise.wanted) plan.denoiser.emplace(options.denoise.library);
  if (!options.until_error.empty()) session.max_error = parse_fraction("--until-error", options.until_error);
  return plan;
}

// A denoised picture is an estimate without an error, so the original must not be lost.
void plan_denoising(Plan& plan) {
  if (!plan.denoiser) return;
  if (std::ranges::none_of(plan.outputs, [](const std::string& path) { return path.ends_with(".exr"); }))
    throw Error(ErrorKind::usage,
                "--denoise also keeps the noisy picture and its error, which only an EXR file holds; add -o "
                "NAME.exr.");
  for (const std::string& path : plan.outputs) plan.denoised.push_back(denoised_name(path));
}

// All files must be different, so that none overwrites another; but a film may replace the film that it continues.
void check_files(const Plan& plan, const RenderArguments& options) {
  std::vector<NamedFile> files = {{"--checkpoint", options.checkpoint}};
  for (const std::string& path : plan.outputs) files.emplace_back("-o", path);
  for (const std::string& path : plan.denoised) files.emplace_back("--denoise writing", path);
  for (const std::string& path : options.heat_maps) files.emplace_back("--heat-map", path);
  for (const NamedFile& report : options.results.named_files()) files.push_back(report);
  check_distinct(files);
  for (const auto& [option, path] : files) {
    const bool film = option == "--checkpoint" || (option == "-o" && plan.film && path.ends_with(".exr"));
    if (!film) check_distinct({{"--resume", options.resume}, {option, path}});
  }
  for (const auto& [option, path] : files) {
    if (!path.empty()) check_writable(path);
  }
}

// Nothing if all samples are in the film.
std::string rejected_text(const RenderJob& job) {
  std::uint64_t count = job.state().film.rejected();
  for (const AovFilm& aov : job.state().aovs) count += aov.film.rejected();
  if (count == 0) return "";
  const std::uint32_t width = job.state().film.width();
  std::string places;
  for (std::size_t i = 0; i < std::min<std::size_t>(job.rejected().size(), 4); ++i) {
    const RejectedSample& r = job.rejected()[i];
    places += fmt::format("{} pixel ({}, {}) sample {} segment {}", i == 0 ? ":" : ";", r.id.pixel % width,
                          r.id.pixel / width, r.id.sample, r.segments);
  }
  return fmt::format("{} samples were not finite or too large for the film and were left out{}", count, places);
}

/// The outcome of one run, for the report.
struct Outcome {
  SessionEnd end;
  std::uint64_t samples = 0;  ///< sample indices rendered by this run
  double render_seconds = 0, seconds = 0;
  std::optional<RenderProfile> profile;
  std::optional<TevViewer::Report> shown;
  OutputWriter files;
};

// Says so if a render continued to its last sample because the error bound was not reached.
std::string missed_error_text(const Film& film, const std::string& wanted) {
  const double error = stopping_error(film);
  return std::isinf(error)
             ? fmt::format(", all of them: no error is known yet, --until-error {} was not reached", wanted)
             : fmt::format(", all of them, with an error of {:.3g} % for --until-error {}", 100.0 * error, wanted);
}

std::string reason_text(const Outcome& outcome, const RenderJob& job, const RenderArguments& options,
                        std::uint32_t set_size) {
  const std::uint64_t total = job.total() * set_size;
  switch (outcome.end) {
    case SessionEnd::complete:
      return options.until_error.empty() ? "" : missed_error_text(job.state().film, options.until_error);
    case SessionEnd::time:
      return fmt::format(" of {}, stopped by --time {}", total, options.time);
    case SessionEnd::error:
      return fmt::format(" of at most {}, good enough for --until-error {}", total, options.until_error);
    case SessionEnd::interrupted:
      return fmt::format(" of {}, interrupted", total);
  }
  return "";
}

Json outcome_json(const Outcome& outcome, const RenderJob& job, const RenderArguments& options, const Plan& plan,
                  const DeviceTeam& team) {
  const double pixel_samples = static_cast<double>(outcome.samples * job.pixels() * plan.session.set_size);
  Json out = {{"outputs", outcome.files.written()},
              {"film", plan.film},
              {"checkpoint", options.checkpoint},
              {"end", to_text(outcome.end)},
              {"metadata", film_metadata(job.state())},
              {"seconds", outcome.seconds},
              {"render_seconds", outcome.render_seconds},
              {"samples_per_second", outcome.render_seconds > 0 ? pixel_samples / outcome.render_seconds : 0.0},
              {"rejected", job.state().film.rejected()},
              {"devices", Json::array()}};
  if (!outcome.files.failed().empty()) out["failed"] = outcome.files.failed();
  for (const Renderer* renderer : team.renderers()) {
    Json device = {{"device", renderer->device_name()}, {"driver", renderer->driver_name()}};
    if (uses_gpu(options)) {
      const GpuTimings t = gpu_timings(*renderer);
      device["timings"] = {
          {"compile", t.compile}, {"upload", t.upload}, {"pipeline", t.pipeline}, {"render", t.render}};
      if (!out.contains("timings")) out["timings"] = device["timings"];
    }
    out["devices"].push_back(device);
  }
  if (plan.denoiser) out["denoised"] = {{"by", plan.denoiser->name()}, {"outputs", plan.denoised}};
  if (outcome.shown) {
    out["tev"] = {
        {"address", to_text(*plan.tev)}, {"pictures", outcome.shown->pictures}, {"last", outcome.shown->last}};
  }
  if (outcome.profile) out["stats"] = stats_json(*outcome.profile, gpu_timings(*team.renderers().front()));
  return out;
}

void report(Outcome& outcome, const RenderJob& job, const RenderArguments& options, Plan& plan,
            const DeviceTeam& team) {
  const std::uint32_t set_size = plan.session.set_size;
  if (plan.frame) {
    Json json = outcome_json(outcome, job, options, plan, team);
    json["frame"] = *plan.frame;
    plan.reports.push_back(std::move(json));
  } else {
    OutputWriter json_file;
    options.results.write_json(json_file, [&] { return outcome_json(outcome, job, options, plan, team); });
    outcome.files.add_failures(json_file);
  }
  if (options.results.wants_text()) {
    const Film& film = job.state().film;
    const double rate =
        static_cast<double>(outcome.samples * job.pixels() * set_size) / std::max(outcome.render_seconds, 1e-9);
    const std::vector<std::string>& written = outcome.files.written();
    log::info(fmt::format("Rendered {}x{} at {} spp{} in {} ({:.2f} Msamples/s); wrote {}.", film.width(),
                          film.height(), job.done() * set_size, reason_text(outcome, job, options, set_size),
                          duration_text(outcome.render_seconds), rate * 1e-6,
                          written.empty() ? "nothing" : fmt::format("{}", fmt::join(written, " and "))));
  }
  if (outcome.profile && options.stats && options.results.wants_text())
    print_text(stats_text(*outcome.profile, gpu_timings(*team.renderers().front())));
}

// Statistics and heat maps are counted afterwards, on the first device and for a few samples, so they do not slow the
// render down.
std::optional<RenderProfile> count_profile(const DeviceTeam& team, const RenderArguments& options) {
  constexpr std::uint32_t kProfiledSamples = 4;
  if (!options.stats && options.heat_maps.empty()) return std::nullopt;
  return gpu_profile(*team.renderers().front(), kProfiledSamples);
}

// Writes the samples so far; each file only where it replaces nothing more valuable.
void write_outputs(OutputWriter& files, const RenderJob& job, const RenderArguments& options, const Plan& plan) {
  const NewPicture picture{header_of(job.state()), plan.film};
  for (const std::string& path : plan.outputs)
    files.write_somewhere(path, [&] {
      const std::string place = place_of(path, picture, options.overwrite);
      write_output(place, job.state(), plan.film, options.display.display());
      return place;
    });
}

// The name listed by the viewer, which must not be the path of a file that it may have open.
std::string viewer_name(const Plan& plan) {
  return "etendue: " + std::filesystem::path(plan.outputs.front()).filename().string();
}

void write_denoised(OutputWriter& files, const RenderJob& job, const RenderArguments& options, const Plan& plan) {
  if (!plan.denoiser) return;
  const Image image = plan.denoiser->denoise(image_from_film(job.state()), "the picture");
  NewPicture picture{header_of(job.state()), false};
  picture.header.metadata = image.metadata;
  for (const std::string& path : plan.denoised)
    files.write_somewhere(path, [&] {
      const std::string place = place_of(path, picture, options.overwrite);
      write_picture(place, image, options.display.display());
      return place;
    });
}

SessionEnd run_session(RenderJob& job, Checkpoint& checkpoint, DeviceTeam& team, const RenderArguments& options,
                       const Plan& plan, SignalWatch& signals, TevViewer* viewer) {
  const std::uint64_t paths = job.pixels() * plan.session.set_size;
  ProgressLine line(options.results.quiet, job.done() * paths, job.total() * paths);
  const auto viewer_waits = [&] { return viewer != nullptr && viewer->wants_picture(); };
  const auto write_picture = [&] {
    if (viewer_waits()) viewer->show([&] { return image_from_film(job.state()); });
    if (!signals.take_image_request()) return;
    OutputWriter files;
    write_outputs(files, job, options, plan);
    if (!files.failed().empty()) log::warning(files.complaint() + ". The render continues.");
  };
  Session session(job, checkpoint, plan.session,
                  {.stop_asked = [&] { return signals.stop_asked(); },
                   .picture_asked = [&] { return signals.image_asked() || viewer_waits(); },
                   .write_picture = write_picture,
                   .progress = [&](std::uint64_t done) { line.update(done); },
                   .warn = [](const std::string& sentence) { log::warning(sentence); }});
  signals.saving_starts();
  return session.run(team);
}

Ending run_job(RenderJob& job, Checkpoint& checkpoint, DeviceTeam& team, const RenderArguments& options, Plan& plan,
               SignalWatch& signals) {
  if (const std::string ahead = checkpoint.samples_ahead(); !ahead.empty()) {
    log::warning(
        fmt::format("{} holds the samples {} of this render already and is kept until this run has them as "
                    "well; '--resume {}' continues from there.",
                    options.checkpoint, ahead, options.checkpoint));
  }
  const std::uint64_t before = job.done();
  std::optional<TevViewer> viewer;
  if (plan.tev) viewer.emplace(*plan.tev, viewer_name(plan));
  const auto render_start = Clock::now();
  Outcome outcome{.end = run_session(job, checkpoint, team, options, plan, signals, viewer ? &*viewer : nullptr)};
  outcome.render_seconds = std::chrono::duration<double>(Clock::now() - render_start).count();
  outcome.samples = job.done() - before;
  if (job.done() == 0) {
    log::warning("Interrupted before the first pass was finished; nothing was written.");
    return Ending::interrupted;
  }
  // The checkpoint comes first; after that, a failure with one file does not affect the others.
  OutputWriter checkpoint_file;
  if (!plan.frame || outcome.end != SessionEnd::complete)  // a finished frame needs no checkpoint
    checkpoint_file.write(options.checkpoint, [&] { checkpoint.save(); });
  if (const std::string text = rejected_text(job); !text.empty()) {
    if (options.scene.strict && !checkpoint_file.failed().empty()) log::warning(checkpoint_file.complaint() + ".");
    if (options.scene.strict)
      throw Error(ErrorKind::comparison, text + "; without --strict the image is written without them.");
    log::warning(text);
  }
  write_outputs(outcome.files, job, options, plan);
  write_denoised(outcome.files, job, options, plan);
  // After the files, which must not wait for a viewer.
  if (viewer) {
    const bool interrupted = outcome.end == SessionEnd::interrupted;
    outcome.shown = viewer->finish(image_from_film(job.state()), [&] { return !interrupted && signals.stop_asked(); });
  }
  outcome.seconds = std::chrono::duration<double>(Clock::now() - plan.session.start).count();
  if (outcome.end != SessionEnd::interrupted) outcome.profile = count_profile(team, options);
  if (outcome.profile) {
    for (const std::string& path : options.heat_maps)
      outcome.files.write(path, [&] { write_heat_map(path, *outcome.profile); });
  }
  report(outcome, job, options, plan, team);
  outcome.files.add_failures(checkpoint_file);
  outcome.files.finish();
  return outcome.end == SessionEnd::interrupted ? Ending::interrupted : Ending::ok;
}

// Checks before the render, not after it, whether existing files are worth more than the new ones.
void check_outputs(const RenderArguments& options, const Plan& plan, const FilmHeader& wanted) {
  FilmHeader heat = wanted;
  heat.samples.clear();
  std::vector<std::string> notes;
  for (const std::string& path : plan.outputs)
    notes.push_back(check_replaceable(path, {wanted, plan.film}, options.overwrite));
  FilmHeader denoised = wanted;
  denoised.metadata[kDenoisedKey] = "";
  for (const std::string& path : plan.denoised)
    notes.push_back(check_replaceable(path, {denoised, false}, options.overwrite));
  for (const std::string& path : options.heat_maps)
    notes.push_back(check_replaceable(path, {heat, false}, options.overwrite));
  for (const std::string& note : notes) {
    if (!note.empty()) log::info(note);
  }
}

// The AOVs of the command in addition to those of the scene.
void add_aovs(const RenderArguments& options, Scene& scene) {
  for (const Aov aov : parse_aovs(options.aovs)) {
    const std::string complaint = aov_complaint(scene.integrator, aov);
    if (!complaint.empty()) throw Error(ErrorKind::usage, fmt::format("'--aov {}': {}.", options.aovs, complaint));
    scene.aovs.push_back(aov);
  }
  if (options.denoise.wanted) scene.aovs.insert(scene.aovs.end(), {Aov::albedo, Aov::normal});
  if (options.alpha) {
    scene.aovs.push_back(Aov::alpha);
    scene.integrator.hide_background = true;
  }
}

/// The state shared by several pictures, of one scene or of several.
struct Stage {
  std::shared_ptr<Scene> scene;
  bool is_new = true;                ///< the scene, to the team
  std::optional<DeviceTeam> team{};  ///< looks at the scene as it was
};

Scene read_prepared(const RenderArguments& options, ReadOptions read) {
  const std::vector<Aov> aovs = parse_aovs(options.aovs);
  read.shows_uv = std::ranges::find(aovs, Aov::uv) != aovs.end();
  Scene scene = read_scene(options.scene_file, read);
  options.sampling.set_size(scene);
  add_aovs(options, scene);
  return scene;
}

// Opens the devices, unless only their view of the scene changes.
void prepare_team(Stage& stage, const RenderArguments& options, const FilmHeader& identity) {
  AovPlan aovs = aov_plan(*stage.scene, options.sampling.seed, identity);
  if (!std::exchange(stage.is_new, false)) return stage.team->look_at(std::move(aovs));
  if (const std::string sentence = precision_complaint(*stage.scene); uses_gpu(options) && !sentence.empty())
    log::warning("the camera: " + sentence);
  // Compiled once for all devices, including reopened ones. Only the camera moves, and it is not compiled.
  const SharedScene shared{std::shared_ptr<const Scene>(stage.scene)};
  std::vector<OpenRenderer> open;
  for (const RendererFactory& factory : options.device.factories()) {
    open.push_back([factory, shared, settings = RenderSettings{.seed = options.sampling.seed}] {
      return factory(shared, settings);
    });
  }
  if (stage.team) return stage.team->show(shared, std::move(open), std::move(aovs));
  stage.team.emplace(std::move(open), std::move(aovs));
  if (uses_gpu(options)) {
    for (const Renderer* renderer : stage.team->renderers()) log::info(gpu_device_choice(*renderer));
  }
}

bool frame_is_there(const RenderArguments& options, const Plan& plan, const FilmHeader& wanted) {
  if (!plan.frame || options.overwrite.force) return false;
  std::vector<FrameFile> files;
  for (const std::string& path : plan.outputs) files.push_back({path, plan.film && path.ends_with(".exr"), false});
  for (const std::string& path : plan.denoised) files.push_back({path, false, true});
  const auto exists = [](const std::string& path) {
    std::error_code error;
    return std::filesystem::exists(path, error);
  };
  if (!std::ranges::all_of(options.heat_maps, exists) || !is_finished(files, wanted)) return false;
  log::info(fmt::format("Frame {} exists already; --force renders it again.", *plan.frame));
  return true;
}

void resume(RenderJob& job, const RenderArguments& options, const Plan& plan) {
  if (options.resume.empty()) return;
  try {
    job.resume(read_film(options.resume), options.resume);
  } catch (const Error& error) {
    if (!plan.frame) throw;
    throw Error(
        error.kind(),
        fmt::format("Frame {} was interrupted and cannot continue: {}; delete that file, or start again with --force.",
                    *plan.frame, error.what()));
  }
}

Ending render_picture(const RenderArguments& options, Plan& plan, Stage& stage, SignalWatch& signals) {
  const Scene& scene = *stage.scene;
  plan.outputs = output_paths(options, scene);
  plan.denoised.clear();
  plan_denoising(plan);
  options.display.check(plan.outputs);
  plan.session.set_size = scene.sampler.set_size();
  const SampleRange wanted = wanted_samples(options, scene);
  FilmHeader identity = film_identity(scene, options.sampling.seed);
  RenderJob job(identity, {{wanted.begin, wanted.end}});
  identity.samples = {{wanted.begin, wanted.end}};
  if (frame_is_there(options, plan, identity)) return Ending::ok;
  resume(job, options, plan);
  check_files(plan, options);
  check_outputs(options, plan, identity);
  Checkpoint checkpoint(options.checkpoint, job);
  prepare_team(stage, options, identity);
  return run_job(job, checkpoint, *stage.team, options, plan, signals);
}

void check_frame_options(const RenderArguments& options) {
  const auto refuse = [](const char* option, const char* why) {
    throw Error(ErrorKind::usage, fmt::format("{} does not go with --frames: {}.", option, why));
  };
  if (!options.time.empty())
    refuse("--time", "every frame gets all of its samples; stop with Ctrl-C and continue later");
  if (!options.until_error.empty()) refuse("--until-error", "existing frames are recognised by their samples");
  if (!options.resume.empty()) refuse("--resume", "interrupted frames continue by themselves");
  if (!options.scene.at.empty()) refuse("--at", "each frame has its own time, given by --fps");
  // Checked before a scene is read: every name has a place for the number.
  for (const std::string& path : options.outputs) frame_name("-o", path, 0);
  for (const std::string& path : options.heat_maps) frame_name("--heat-map", path, 0);
  if (!options.checkpoint.empty()) frame_name("--checkpoint", options.checkpoint, 0);
}

// The same for one frame: its file names, and the film to continue if it was interrupted.
RenderArguments frame_arguments(const RenderArguments& options, const Scene& scene, std::uint32_t frame) {
  RenderArguments one = options;
  one.outputs = output_paths(options, scene);
  for (std::string& path : one.outputs) path = frame_name("-o", path, frame);
  for (std::string& path : one.heat_maps) path = frame_name("--heat-map", path, frame);
  if (options.checkpoint.empty()) {
    std::filesystem::path name(one.outputs.front());
    one.checkpoint = name.replace_extension(".checkpoint.exr").string();
  } else {
    one.checkpoint = frame_name("--checkpoint", options.checkpoint, frame);
  }
  std::error_code error;
  const bool interrupted =
      std::filesystem::is_regular_file(one.checkpoint, error) && std::filesystem::file_size(one.checkpoint, error) > 0;
  if (interrupted && options.overwrite.force) std::filesystem::remove(one.checkpoint, error);
  if (interrupted && !options.overwrite.force) one.resume = one.checkpoint;
  return one;
}

// If only the camera moves, the scene is read and compiled once; if anything else moves, each frame is a new scene.
void set_stage(Stage& stage, const RenderArguments& options, double time) {
  ReadOptions read = options.scene.read_options();
  if (is_gltf(options.scene_file)) {
    read.at = time;
    stage.scene = std::make_shared<Scene>(read_prepared(options, read));
    stage.is_new = true;
    return;
  }
  if (!stage.scene) stage.scene = std::make_shared<Scene>(read_prepared(options, read));
  Camera& camera = stage.scene->camera;
  if (camera.path.empty())
    throw Error(
        ErrorKind::usage,
        fmt::format("--frames: nothing in {} moves; give its camera keyframes (docs/cameras.md).", options.scene_file));
  camera.world_from_camera = pose_at(camera.path, time);
}

Ending render_frames(const RenderArguments& options, Plan& plan, SignalWatch& signals) {
  check_frame_options(options);
  const SampleRange frames = parse_frames(options.frames.range);
  Stage stage;
  Ending ending = Ending::ok;
  for (std::uint32_t frame = frames.begin; frame < frames.end && ending == Ending::ok; ++frame) {
    if (signals.stop_asked()) {
      ending = Ending::interrupted;
      break;
    }
    set_stage(stage, options, frame / options.frames.fps);
    const RenderArguments one = frame_arguments(options, *stage.scene, frame);
    plan.frame = frame;
    plan.session.start = Clock::now();
    const std::size_t rendered = plan.reports.size();
    ending = render_picture(one, plan, stage, signals);
    std::error_code ignored;
    if (ending == Ending::ok && plan.reports.size() > rendered) std::filesystem::remove(one.checkpoint, ignored);
  }
  OutputWriter files;
  options.results.write_json(files, [&] { return Json({{"fps", options.frames.fps}, {"frames", plan.reports}}); });
  files.finish();
  return ending;
}

Ending render(const RenderArguments& options) {
  options.results.begin();
  Plan plan = make_plan(options, Clock::now());
  SignalWatch signals(options.results.quiet);
  if (options.frames.wanted()) return render_frames(options, plan, signals);
  Stage stage{.scene = std::make_shared<Scene>(read_prepared(options, options.scene.read_options()))};
  return render_picture(options, plan, stage, signals);
}

void add_job_options(Command& command, RenderArguments& options) {
  command
      .add_option("--samples", options.samples,
                  "render only the samples A to B - 1 and write films that 'etendue merge' adds up")
      ->type_name("A:B")
      ->group(kPieces);
  command
      .add_flag("--film", options.film,
                "write .exr files as films, which can be merged and resumed, instead of pictures")
      ->group(kPieces);
  command
      .add_option("--checkpoint", options.checkpoint,
                  "film file with everything rendered so far, written from time to time and at the end")
      ->file({".exr"})
      ->group(kPieces);
  command.add_option("--checkpoint-every", options.checkpoint_every, "time between checkpoints (default: 60s)")
      ->type_name("TIME")
      ->group(kPieces);
  command.add_option("--resume", options.resume, "continue from a checkpoint or another film of the same render")
      ->file({".exr"})
      ->group(kPieces);
  command
      .add_option("--time", options.time,
                  "stop after this time, for example 10m, which includes reading the scene but not writing the picture")
      ->type_name("TIME")
      ->group(kPieces);
  command
      .add_option("--until-error", options.until_error,
                  "stop when the relative standard error of the picture is at most this, for example 1%; tested after "
                  "16, 24, 32, 48, 64 … samples (sobol: 4, 6, 8, 12, 16 … sets)")
      ->type_name("FRACTION")
      ->group(kPieces);
}

}  // namespace

void add_render_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("render", "render a scene to EXR and PNG");
  const auto options = std::make_shared<RenderArguments>();
  command->add_option("SCENE", options->scene_file, "scene file")->required()->file(kSceneEndings);
  command
      ->add_option(
          "-o,--output,--out", options->outputs,
          "picture to write, .exr or .png; may be repeated (default: <scene name>.exr and .png in the current folder)")
      ->allow_extra_args(false)
      ->file({".exr", ".png"});
  options->sampling.add_to(*command);
  command
      ->add_option("--aov", options->aovs,
                   "additional channels in .exr files, separated by commas: depth, position, normal, albedo …")
      ->type_name("NAMES");
  command->add_flag(
      "--alpha", options->alpha,
      "write coverage as the channel A and leave out the background, so that pictures are transparent there");
  options->frames.add_to(*command);
  add_job_options(*command, *options);
  options->scene.add_to(*command);
  options->device.add_to(*command, true);
  command->add_flag("--stats", options->stats,
                    "count rays, nodes, primitives and active lanes, using some additional samples");
  command
      ->add_option(
          "--heat-map", options->heat_maps,
          "cost of each pixel: nodes, primitives and rays per sample as .exr, false colours as .png; may be repeated")
      ->allow_extra_args(false)
      ->file({".exr", ".png"});
  command->add_optional_value("--tev", options->tev, "HOST:PORT",
                              "show the picture during the render in the viewer tev, by default at 127.0.0.1:14158");
  options->denoise.add_with_flag(*command);
  options->display.add_to(*command);
  options->overwrite.add_to(*command);
  options->results.add_to(*command);
  command->footer(
      "SIGINT, SIGTERM, SIGHUP or a limit or timer signal (SIGXCPU, SIGALRM …): finish the pass, write picture and "
      "checkpoint, end with code 130; a second SIGINT or SIGTERM aborts. SIGUSR1: write the current picture.");
  command->callback([&action, options] { action = [options] { return render(*options); }; });
}

}  // namespace etendue::cli
