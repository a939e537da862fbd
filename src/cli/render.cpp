#include <chrono>
#include <limits>

#include <fmt/core.h>
#include <fmt/ranges.h>
#include "cli/command.h"
#include "cli/render_session.h"
#include "cli/render_stats.h"
#include "cli/units.h"
#include "core/json.h"
#include "core/log.h"
#include "core/version.h"
#include "gpu/gpu_renderer.h"

namespace etendue::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string scene_file;
  SceneOptions scene;
  DeviceOption device;
  std::vector<std::string> outputs;
  std::uint32_t spp = 0;  ///< 0: what the scene says
  std::uint32_t seed = 0;
  std::string size;
  std::string samples;
  std::string checkpoint, checkpoint_every, resume;
  std::string time, until_error;
  bool film = false;
  bool quiet = false;
  bool json = false;
  bool stats = false;
  std::vector<std::string> heat_maps;  ///< .exr and .png
};

bool uses_gpu(const Options& options) {
  return options.device.selector != "reference";
}

std::string integrator_text(const Scene& scene) {
  const Integrator& integrator = scene.integrator;
  if (integrator.type == Integrator::Type::normals) return "normals";
  return fmt::format("path maxDepth={} nee={} mis={} rrDepth={}{}", integrator.max_depth, integrator.nee,
                     integrator.mis, integrator.rr_depth, uses_light_tree(scene) ? " lightSampler=tree" : "");
}

// What every film of this render agrees on. Nothing in a file depends on the time or the place of the run.
FilmHeader identity(const Scene& scene, std::uint32_t seed) {
  FilmHeader header{.width = scene.camera.width,
                    .height = scene.camera.height,
                    .exponent = film_exponent(scene),
                    .metadata = {{"software", "Etendue"},
                                 {"version", version()},
                                 {"scene", scene.name},
                                 {"sceneHash", fmt::format("{:016x}", scene_hash(scene))},
                                 {"seed", std::to_string(seed)},
                                 {"integrator", integrator_text(scene)}}};
  if (scene.sampler.type == Sampler::Type::sobol)
    header.metadata["sampler"] = fmt::format("sobol setSize={}", scene.sampler.set_size());
  return header;
}

// A range of paths as film samples. A film knows whole sets only.
SampleRange whole_sets(const SampleRange& paths, const Sampler& sampler) {
  const std::uint32_t size = sampler.set_size();
  if (paths.begin % size == 0 && paths.end % size == 0) return {paths.begin / size, paths.end / size};
  throw Error(
      ExitCode::usage,
      fmt::format("'--samples {}:{}' cuts a set of the sobol sampler, whose sets have {} samples; give multiples "
                  "of {}.",
                  paths.begin, paths.end, size, size));
}

// All samples of the render, in film samples: whole sets.
SampleRange all_samples(std::uint32_t paths, const Sampler& sampler) {
  const std::uint64_t sets = sampler.sets_of(paths);
  const std::uint64_t rounded = sets * sampler.set_size();
  if (rounded > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ExitCode::usage, fmt::format("{} samples a pixel are {} in whole sets of {}; there may be 2^32 - 1.",
                                             paths, rounded, sampler.set_size()));
  }
  if (rounded != paths)
    log::info(fmt::format("{} samples a pixel become {}: the sobol sampler takes whole sets of {}.", paths, rounded,
                          sampler.set_size()));
  return {0, static_cast<std::uint32_t>(sets)};
}

// In film samples, which are sets of paths.
SampleRange wanted_samples(const Options& options, const Scene& scene) {
  if (options.samples.empty())
    return all_samples(options.spp > 0 ? options.spp : scene.sampler.sample_count, scene.sampler);
  const SampleRange range = parse_samples(options.samples);
  if (options.spp > 0 && range.end > options.spp) {
    throw Error(
        ExitCode::usage,
        fmt::format("'--samples {}' ends beyond the {} samples of '--spp'; a range of an N spp render lies inside 0:N.",
                    options.samples, options.spp));
  }
  return whole_sets(range, scene.sampler);
}

std::vector<std::string> output_paths(const Options& options, const Scene& scene) {
  if (options.outputs.empty()) return {scene.name + ".exr", scene.name + ".png"};
  return options.outputs;
}

SessionOptions session_options(const Options& options, Clock::time_point start) {
  if (!options.checkpoint_every.empty() && options.checkpoint.empty()) {
    throw Error(ExitCode::usage, "'--checkpoint-every' needs the file to write: add --checkpoint FILE.");
  }
  for (const std::string& path : options.outputs) check_output_name(path);
  SessionOptions session{.film = options.film || !options.samples.empty(),
                         .checkpoint = options.checkpoint,
                         .start = start,
                         .quiet = options.quiet};
  if (!options.checkpoint_every.empty())
    session.checkpoint_seconds = parse_duration("--checkpoint-every", options.checkpoint_every);
  if (!options.time.empty()) session.time_seconds = parse_duration("--time", options.time);
  if (!options.until_error.empty()) session.max_error = parse_fraction("--until-error", options.until_error);
  return session;
}

void report_rejected(const RenderJob& job, bool strict) {
  const std::uint64_t count = job.state().film.rejected();
  if (count == 0) return;
  const std::uint32_t width = job.state().film.width();
  std::string places;
  for (std::size_t i = 0; i < std::min<std::size_t>(job.rejected().size(), 4); ++i) {
    const RejectedSample& r = job.rejected()[i];
    places += fmt::format("{} pixel ({}, {}) sample {} segment {}", i == 0 ? ":" : ";", r.id.pixel % width,
                          r.id.pixel / width, r.id.sample, r.segments);
  }
  const std::string text =
      fmt::format("{} samples were not finite or too large for the film and were left out{}", count, places);
  if (strict) throw Error(ExitCode::test_failed, text + "; without --strict the image is written without them.");
  log::warning(text);
}

/// What one run did, for the report.
struct Outcome {
  SessionEnd end;
  std::uint64_t samples = 0;  ///< sample indices rendered by this run
  double render_seconds = 0, seconds = 0;
  std::optional<RenderProfile> profile;
};

std::string reason_text(const Outcome& outcome, const RenderJob& job, const Options& options, std::uint32_t set_size) {
  const std::uint64_t total = job.total() * set_size;
  switch (outcome.end) {
    case SessionEnd::complete:
      return "";
    case SessionEnd::time:
      return fmt::format(" of {}, stopped by --time {}", total, options.time);
    case SessionEnd::error:
      return fmt::format(" of at most {}, good enough for --until-error {}", total, options.until_error);
    case SessionEnd::interrupted:
      return fmt::format(" of {}, interrupted", total);
  }
  return "";
}

Json to_json(const Outcome& outcome, const RenderJob& job, const SessionOptions& session, const DeviceTeam& team,
             bool gpu) {
  const double pixel_samples = static_cast<double>(outcome.samples * job.pixels() * session.set_size);
  Json out = {{"outputs", session.outputs},
              {"film", session.film},
              {"checkpoint", session.checkpoint},
              {"end", to_text(outcome.end)},
              {"metadata", film_metadata(job.state())},
              {"seconds", outcome.seconds},
              {"render_seconds", outcome.render_seconds},
              {"samples_per_second", outcome.render_seconds > 0 ? pixel_samples / outcome.render_seconds : 0.0},
              {"rejected", job.state().film.rejected()},
              {"devices", Json::array()}};
  for (const Renderer* renderer : team.renderers()) {
    Json device = {{"device", renderer->device_name()}, {"driver", renderer->driver_name()}};
    if (gpu) {
      const GpuTimings t = gpu_timings(*renderer);
      device["timings"] = {
          {"compile", t.compile}, {"upload", t.upload}, {"pipeline", t.pipeline}, {"render", t.render}};
      if (!out.contains("timings")) out["timings"] = device["timings"];
    }
    out["devices"].push_back(device);
  }
  if (outcome.profile) out["stats"] = stats_json(*outcome.profile, gpu_timings(*team.renderers().front()));
  return out;
}

void report(const Outcome& outcome, const RenderJob& job, const Options& options, const SessionOptions& session,
            const DeviceTeam& team) {
  if (options.json) {
    fmt::print("{}\n", to_json(outcome, job, session, team, uses_gpu(options)).dump(2));
  } else if (!options.quiet) {
    const Film& film = job.state().film;
    const double rate =
        static_cast<double>(outcome.samples * job.pixels() * session.set_size) / std::max(outcome.render_seconds, 1e-9);
    log::info(fmt::format("Rendered {}x{} at {} spp{} in {} ({:.2f} Msamples/s); wrote {}.", film.width(),
                          film.height(), job.done() * session.set_size,
                          reason_text(outcome, job, options, session.set_size), duration_text(outcome.render_seconds),
                          rate * 1e-6, fmt::join(session.outputs, " and ")));
  }
  if (outcome.profile && options.stats && !options.json)
    fmt::print("{}", stats_text(*outcome.profile, gpu_timings(*team.renderers().front())));
}

// Statistics and heat maps are counted afterwards, on the first device and a few samples: the render pays nothing.
std::optional<RenderProfile> count_profile(const DeviceTeam& team, const Options& options) {
  constexpr std::uint32_t kProfiledSamples = 4;
  if (!options.stats && options.heat_maps.empty()) return std::nullopt;
  RenderProfile profile = gpu_profile(*team.renderers().front(), kProfiledSamples);
  for (const std::string& path : options.heat_maps) write_heat_map(path, profile);
  return profile;
}

ExitCode run_job(RenderJob& job, DeviceTeam& team, const Options& options, const SessionOptions& session) {
  const std::uint64_t before = job.done();
  const auto render_start = Clock::now();
  Session run(job, session);
  Outcome outcome{.end = run.run(team)};
  outcome.render_seconds = std::chrono::duration<double>(Clock::now() - render_start).count();
  outcome.samples = job.done() - before;
  if (job.done() == 0) {
    log::warning("Interrupted before the first pass was finished; nothing was written.");
    return ExitCode::interrupted;
  }
  run.save_checkpoint();
  report_rejected(job, options.scene.strict);
  run.write_outputs();
  outcome.seconds = std::chrono::duration<double>(Clock::now() - session.start).count();
  if (outcome.end != SessionEnd::interrupted) outcome.profile = count_profile(team, options);
  report(outcome, job, options, session, team);
  return outcome.end == SessionEnd::interrupted ? ExitCode::interrupted : ExitCode::ok;
}

ExitCode render(const Options& options) {
  for (const std::string& path : options.heat_maps) check_output_name(path);
  if ((options.stats || !options.heat_maps.empty()) && !uses_gpu(options))
    throw Error(ExitCode::usage, "--stats and --heat-map count on a Vulkan device; choose another --device.");
  SessionOptions session = session_options(options, Clock::now());
  Scene scene = read_scene(options.scene_file, options.scene.read_options());
  if (!options.size.empty()) {
    const Size size = parse_size(options.size);
    scene.camera.width = size.width;
    scene.camera.height = size.height;
  }
  session.outputs = output_paths(options, scene);
  session.set_size = scene.sampler.set_size();
  const SampleRange wanted = wanted_samples(options, scene);
  RenderJob job(identity(scene, options.seed), {{wanted.begin, wanted.end}});
  if (!options.resume.empty()) job.resume(read_film(options.resume), options.resume);
  for (const std::string& path : session.outputs) check_writable(path);
  for (const std::string& path : options.heat_maps) check_writable(path);
  if (!session.checkpoint.empty()) check_checkpoint(session.checkpoint);

  std::vector<OpenRenderer> open;
  for (const RendererFactory& factory : options.device.factories()) {
    open.push_back(
        [factory, &scene, settings = RenderSettings{.seed = options.seed}] { return factory(scene, settings); });
  }
  DeviceTeam team(std::move(open));
  if (!options.quiet && uses_gpu(options)) {
    for (const Renderer* renderer : team.renderers()) log::info(gpu_device_choice(*renderer));
  }
  return run_job(job, team, options, session);
}

void add_job_options(Command& command, Options& options) {
  command
      .add_option("--samples", options.samples,
                  "render only the samples A to B - 1 and write films that 'etendue merge' adds up")
      ->type_name("A:B");
  command.add_flag("--film", options.film,
                   "write .exr files as films, which can be merged and resumed, instead of pictures");
  command
      .add_option("--checkpoint", options.checkpoint,
                  "film file that keeps what is done, written from time to time and at the end")
      ->type_name("FILE");
  command.add_option("--checkpoint-every", options.checkpoint_every, "time between checkpoints (default: 60s)")
      ->type_name("TIME");
  command.add_option("--resume", options.resume, "go on from a checkpoint or another film of the same render")
      ->type_name("FILE");
  command
      .add_option("--time", options.time,
                  "stop in time, for example 10m; scene reading counts, writing the image does not")
      ->type_name("TIME");
  command
      .add_option("--until-error", options.until_error,
                  "stop when the relative standard error of the image is at most this, for example 1%; looked at after "
                  "16, 24, 32, 48, 64 … samples (sobol: 4, 6, 8, 12, 16 … sets)")
      ->type_name("FRACTION");
}

}  // namespace

void add_render_command(Command& app, Action& action) {
  auto* command = app.add_subcommand("render", "render a scene to EXR and PNG");
  const auto options = std::make_shared<Options>();
  command->add_option("SCENE", options->scene_file, "scene file")->required();
  command
      ->add_option("-o,--output", options->outputs,
                   "image to write, .exr or .png; may be repeated (default: <scene name>.exr and .png here)")
      ->allow_extra_args(false);
  command->add_option("--spp", options->spp, "samples per pixel instead of the scene's sampleCount")
      ->check(in_range(1u, 0xffffffffu));
  command->add_option("--seed", options->seed, "seed of the random numbers")->capture_default_str();
  command->add_option("--size", options->size, "film size instead of the scene's, WxH");
  add_job_options(*command, *options);
  options->scene.add_to(*command);
  options->device.add_to(*command);
  command->add_flag("--stats", options->stats,
                    "count rays, nodes, primitives and working lanes on some samples afterwards");
  command
      ->add_option("--heat-map", options->heat_maps,
                   "what the pixels cost: nodes, primitives and rays per sample as .exr, false colours as .png; may be "
                   "repeated")
      ->allow_extra_args(false);
  command->add_flag("-q,--quiet", options->quiet, "say nothing but errors");
  command->add_flag("--json", options->json, "print what was done as JSON");
  command->footer(
      "SIGINT or SIGTERM: finish the pass, write image and checkpoint, end with code 130; a second one aborts. "
      "SIGUSR1: write the current image.");
  command->callback([&action, options] { action = [options] { return render(*options); }; });
}

}  // namespace etendue::cli
