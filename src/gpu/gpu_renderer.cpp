#include "gpu/gpu_renderer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstring>
#include <list>

#include <fmt/core.h>

#include "core/errors.h"
#include "core/log.h"
#include "core/parallel.h"
#include "gpu/device_film.h"
#include "gpu/device_scene.h"
#include "gpu/device_view.h"
#include "gpu/kernel_set.h"
#include "gpu/pass_sizer.h"
#include "scene/invariants.h"
#include "scene/material_numbers.h"

namespace etendue {
namespace {

// Loop iterations per dispatch. lavapipe ends loops silently after 65 535 iterations per SIMD group, all loops of the
// kernel together; other devices have a bound that keeps a dispatch finite.
constexpr std::uint32_t kCpuIterations = 60000;
constexpr std::uint32_t kGpuIterations = 1u << 22;
// Where each lane counts its own iterations, the walks of a group may run one after the other, so that a group of 8
// takes as many rounds as all of them together.
constexpr std::uint32_t kCpuIterationsDivergent = kCpuIterations / 8;
// Turns of traversal steps between two rounds of shading, and steps per turn: with light sampling, where every other
// ray is a shadow ray, and without. Measured on lavapipe: with fewer steps, fewer lanes are shaded at a time; with
// more, more lanes wait. Where shading is expensive, as with all features that the plain kernel lacks, it waits
// longer.
constexpr std::uint32_t kTurnsNee = 2, kStepsNee = 6, kStepsNeeDear = 12;
constexpr std::uint32_t kTurnsNaive = 1, kStepsNaive = 8;
constexpr double kGpuPassSeconds = 0.1;  // so that no watchdog fires
constexpr double kCpuPassSeconds = 1.0;  // there is no watchdog, and fewer dispatches waste less
// A place of the film that was not rendered yet, such as glass beside walls, is taken to be so many times dearer.
constexpr double kCaution = 4.0;
// Paths per second assumed for the first dispatch where a watchdog may fire: slow GPUs trace ten times as many.
constexpr double kFirstRateWatched = 1e4;
// Paths per lane in a dispatch, one after the other, where this can be chosen: at its end, lanes wait for slower ones,
// for a time that grows with the square root of the number of paths.
constexpr std::uint32_t kPathsPerLane = 256;
// Approximate number of rounds of steps and shading per path. A lane whose budget ends before its paths waits for all
// others, and they wait for it when the dispatch is repeated.
constexpr std::uint32_t kRoundsPerPath = 8;
// Workgroups per processor thread in a dispatch: enough to share them evenly.
constexpr std::uint32_t kGroupsPerThread = 16;
constexpr std::uint64_t kMostSamples = 1u << 22;  // per dispatch; 64 MiB
constexpr double kPassTimeout = 300.0;            // seconds; passes are sized to a fraction of one

std::uint32_t iterations_per_round(std::span<const vulkan::Specialization> constants) {
  return std::ranges::find(constants, gpu::kConstantIterationsPerRound, &vulkan::Specialization::id)->value;
}

bool traces_occlusion(Integrator::Type type) {
  using enum Integrator::Type;
  return type == simple || type == ambient_occlusion || type == visibility;
}

// Lanes that keep a device busy.
std::uint32_t wanted_slots(const vulkan::Context& context) {
  return context.is_cpu() ? 4096 : 1u << 17;
}

DeviceNeed most_film_need(const vulkan::Context& context, const Camera& camera) {
  constexpr std::uint32_t kManySamples = ~0u;
  return film_need({camera.width, camera.height, kManySamples, wanted_slots(context)});
}

// Lanes that a dispatch keeps busy; each takes paths one after the other.
std::uint32_t wanted_lane_groups(const vulkan::Context& context) {
  const std::uint32_t groups = context.is_cpu() ? kGroupsPerThread * thread_count() : (1u << 17) / gpu::kWorkgroupSize;
  return std::min(groups, context.limits().maxComputeWorkGroupCount[0]);
}

// The most samples that a dispatch may leave for the film.
std::uint64_t most_samples(const vulkan::Context& context, std::uint32_t lane_groups) {
  return std::min({std::uint64_t{lane_groups} * gpu::kWorkgroupSize * kPathsPerLane, kMostSamples,
                   context.limits().maxStorageBufferRange / sizeof(gpu::vec4)});
}

std::size_t report_bytes(std::uint32_t lane_groups) {
  return sizeof(gpu::ReportHead) + gpu::kRejectedListed * sizeof(gpu::RejectedEntry) +
         std::size_t{lane_groups} * gpu::kWorkgroupSize * sizeof(std::uint32_t);
}

class Timer {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

PassLimits pass_limits(const vulkan::Context& context, const GpuOptions& options, std::uint32_t lane_groups,
                       std::uint32_t rounds) {
  const bool unwatched = context.is_cpu() && !options.pass_seconds;
  return {.seconds = unwatched ? kCpuPassSeconds : options.pass_seconds.value_or(kGpuPassSeconds),
          .most_groups = std::min<std::uint64_t>(most_samples(context, lane_groups) / gpu::kWorkgroupSize,
                                                 context.limits().maxComputeWorkGroupCount[0]),
          .lane_groups = lane_groups,
          .paths_per_lane = std::clamp(rounds / kRoundsPerPath, PassLimits::kLeastPathsPerLane, kPathsPerLane),
          .fixed_samples = options.fixed_samples,
          .fixed_groups = options.fixed_groups,
          .caution = unwatched ? 1.0 : kCaution,
          .first_rate = unwatched ? PassLimits().first_rate : kFirstRateWatched};
}

// Groups of 64 slots for which a dispatch can count so many paths.
std::uint32_t most_profiled(const vulkan::Context& context, std::uint32_t paths) {
  const std::uint64_t bytes =
      std::min<std::uint64_t>(kMostSamples * sizeof(gpu::vec4), context.limits().maxStorageBufferRange);
  const std::uint64_t of_a_group = std::uint64_t{paths} * gpu::kWorkgroupSize * sizeof(gpu::PathProfile);
  return static_cast<std::uint32_t>(std::max(bytes / of_a_group, std::uint64_t{1}));
}

struct Made {
  std::shared_ptr<const CompiledScene> compiled;
  std::shared_ptr<const DeviceScene> scene;
  GpuTimings timings;
};

// Uploads the scene, and compiles it first unless that is done already.
Made make_device_scene(const std::shared_ptr<GpuDevice>& device, const SharedScene& shared, const GpuOptions& options,
                       const DeviceScene::Layouts& like = {}) {
  const DeviceNeed film = most_film_need(*device->context, shared.scene().camera);
  // Checks what is known before the tree is built, which may take gigabytes and minutes.
  check_needs(std::array{film, least_scene_need(shared.scene())}, limits_of(*device->context));
  Made made;
  Timer timer;
  made.compiled = shared.once<CompiledScene>(compile_scene);
  made.timings.compile = timer.seconds();
  timer = {};
  made.scene = std::make_shared<const DeviceScene>(device, made.compiled, options.wanted_loads(), std::span(&film, 1),
                                                   like, options.queries());
  made.timings.upload = timer.seconds();
  return made;
}

class GpuRenderer final : public Renderer {
 public:
  // The scene from which a device scene was made; nothing if only the latter is given.
  struct Source {
    SharedScene scene;
    std::shared_ptr<const CompiledScene> compiled;
    std::shared_ptr<const CompiledLights> lights = compiled;  // as they are now
  };

  GpuRenderer(std::shared_ptr<const DeviceScene> scene, std::optional<Source> source, const View& view,
              const RenderSettings& settings, const GpuOptions& options, const GpuTimings& timings)
      : options_(options),
        source_(std::move(source)),
        scene_(std::move(scene)),
        kernels_(kernel_set(options, scene_->loads())),
        view_(scene_->device()),
        lane_groups_(wanted_lane_groups(context())),
        report_(context(), report_bytes(lane_groups_), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Buffer::Memory::host,
                "report"),
        step_budget_(context().is_cpu() ? kCpuIterations : kGpuIterations),
        timings_(timings) {
    std::memset(report_.mapped().data(), 0, report_.mapped().size());
    set_view(view, settings);
  }

  std::string device_name() const override { return context().info().name; }
  std::string driver_name() const override { return context().info().driver; }
  const GpuTimings& timings() const { return timings_; }
  const std::string& choice() const { return context().choice(); }

  void set_view(const View& view, const RenderSettings& settings) override;
  void set_materials(const std::vector<Material>& materials) override;
  void set_lights(const SharedScene& scene, const RenderSettings& settings) override;
  void set_scene(const SharedScene& scene, const RenderSettings& settings) override;
  std::uint32_t render(SampleRange range, Film& film, const Progress& progress,
                       std::vector<RejectedSample>& rejected) override;
  std::vector<SampleRecord> trace_samples(std::span<const SampleId> ids) override;
  std::vector<PathVertex> trace_path(SampleId id) override;
  RenderProfile profile(std::uint32_t samples);
  std::vector<KernelReport> kernels(const vulkan::Context& compiler) const;

 private:
  class SampleTracer;
  const vulkan::Context& context() const { return *scene_->device().context; }
  vulkan::Commands& commands() { return scene_->device().commands; }
  std::vector<vulkan::Specialization> view_constants(const View& view, const RenderSettings& settings,
                                                     const CompiledView& compiled) const;
  vulkan::Kernel make_kernel(const KernelBindings& layout, std::span<const std::uint32_t> spirv, const char* name) {
    const Timer timer;
    vulkan::Kernel kernel(context(), layout.pipeline, spirv, constants_, name);
    timings_.pipeline += timer.seconds();
    return kernel;
  }
  vulkan::Kernel make_request_kernel(std::span<const std::uint32_t> plain, std::span<const std::uint32_t> full,
                                     const char* name) {
    if (is_plain(constants_)) return make_kernel(scene_->request_kernels(), plain, name);
    return make_kernel(scene_->request_kernels(), full, name);
  }
  vulkan::BindingSet make_film_set(const FilmBand& band, const vulkan::Buffer& samples) const {
    vulkan::BindingSet set(context(), scene_->film_kernels().set);
    view_.bind(set);
    set.bind(gpu::kBindingSetSums, report_);  // replaced if the band has sums of its own
    set.bind(gpu::kBindingSamples, samples);
    set.bind(gpu::kBindingReport, report_);
    band.bind(set);
    return set;
  }
  vulkan::BindingSet make_request_set(const vulkan::Buffer& requests, const vulkan::Buffer& results) const {
    vulkan::BindingSet set(context(), scene_->request_kernels().set);
    view_.bind(set);
    set.bind(gpu::kBindingRequests, requests);
    set.bind(gpu::kBindingResults, results);
    return set;
  }
  // A kernel with its bindings.
  struct Work {
    const KernelBindings& layout;
    const vulkan::Kernel& kernel;
    const vulkan::BindingSet& set;
  };
  double dispatch(const Work& work, const gpu::Pass& pass, std::uint32_t groups) {
    return commands().dispatch(work.layout.pipeline, work.kernel, {&scene_->set(), &work.set},
                               std::as_bytes(std::span(&pass, 1)), groups, kPassTimeout);
  }
  void check_film(const Film& film) const;
  void prepare_film(const SlotLayout& slots);
  void forget_film() {
    film_sets_.clear();
    film_.reset();
    for (RenderKernel& kernel : render_kernels_) kernel.sizer.forget_places();
  }
  gpu::Pass begin_pass(const SlotLayout& slots, SampleRange range) const;
  void run_pass(std::size_t band, gpu::Pass pass, std::uint32_t paths);
  void trace_chunk(const Work& work, gpu::Pass pass);
  gpu::ReportHead take_report();
  // The kernels for certain constants, and their measured speed. AOVs take turns with the picture, so several are kept.
  struct RenderKernel {
    std::vector<vulkan::Specialization> constants;
    PassSizer sizer;
    vulkan::Kernel trace{}, take{};  // paths, and their samples into the film
    bool dispatched = false;
  };
  RenderKernel& present_kernel();

  const Source& source() const;
  void exchange(const std::vector<Material>& materials, const CompiledLights& lights);
  void use_constants();

  GpuOptions options_;
  std::optional<Source> source_;
  std::shared_ptr<const DeviceScene> scene_;
  KernelSet kernels_;
  DeviceView view_;
  const std::uint32_t lane_groups_;
  vulkan::Buffer report_;
  std::vector<vulkan::Specialization> view_constants_, constants_;  // of the view; all of them
  std::list<RenderKernel> render_kernels_;  // the most recent ones; made when first needed, like the next two
  vulkan::Kernel path_kernel_;
  std::unique_ptr<SampleTracer> tracer_;
  vulkan::Buffer samples_;                     // on their way to the film
  std::unique_ptr<DeviceFilm> film_;           // of the last render
  std::vector<vulkan::BindingSet> film_sets_;  // of its bands
  std::uint32_t set_bits_ = 0;                 // of the sampler; the samples of this class are sets of paths
  gpu::Frame frame_{};
  std::uint32_t step_budget_ = 0;
  std::vector<RejectedSample> rejected_;
  GpuTimings timings_;
};

// The trace_samples kernel with its buffers.
class GpuRenderer::SampleTracer {
 public:
  SampleTracer(GpuRenderer& renderer, std::size_t capacity)
      : renderer_(renderer),
        kernel_(renderer.make_request_kernel(renderer.kernels_.trace_samples_plain, renderer.kernels_.trace_samples,
                                             "trace_samples")),
        requests_(renderer.context(), capacity * sizeof(gpu::SampleRequest), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                  vulkan::Buffer::Memory::device, "sample requests"),
        results_(renderer.context(), capacity * sizeof(gpu::SampleResult), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                 vulkan::Buffer::Memory::device, "sample results"),
        set_(renderer.make_request_set(requests_, results_)) {}
  std::vector<gpu::SampleResult> trace(std::span<const SampleId> ids, std::uint32_t budget) const {
    std::vector<gpu::SampleRequest> asked;
    for (const SampleId& id : ids) asked.push_back({id.pixel, id.sample, 0, 0});
    renderer_.commands().upload(requests_, 0, std::as_bytes(std::span(asked)));
    gpu::Pass pass{};
    pass.request_count = static_cast<gpu::uint>(ids.size());
    pass.step_budget = budget;
    renderer_.dispatch({renderer_.scene_->request_kernels(), kernel_, set_}, pass,
                       (pass.request_count + gpu::kWorkgroupSize - 1) / gpu::kWorkgroupSize);
    std::vector<gpu::SampleResult> out(ids.size());
    renderer_.commands().download(results_, 0, std::as_writable_bytes(std::span(out)));
    return out;
  }

 private:
  GpuRenderer& renderer_;
  vulkan::Kernel kernel_;
  vulkan::Buffer requests_, results_;
  vulkan::BindingSet set_;
};

// Kernels are rebuilt only if their constants change; seed, size and camera are not among these.
void GpuRenderer::set_view(const View& view, const RenderSettings& settings) {
  const CompiledView compiled = compile_view(scene_->facts(), view, settings.seed);
  if (film_ && (compiled.frame.width != frame_.width || compiled.frame.height != frame_.height)) {
    forget_film();
    const DeviceNeed film = most_film_need(context(), view.camera);
    check_needs(std::span(&film, 1), limits_of(context()));
  }
  view_.set(scene_->device(), compiled);
  frame_ = compiled.frame;
  set_bits_ = view.sampler.set_bits;
  view_constants_ = view_constants(view, settings, compiled);
  use_constants();
}

void GpuRenderer::set_materials(const std::vector<Material>& materials) {
  exchange(materials, *source().lights);
  use_constants();
}

void GpuRenderer::set_lights(const SharedScene& shared, const RenderSettings& settings) {
  const Scene& scene = shared.scene();
  auto lights = std::make_shared<const CompiledLights>(compile_lights(scene, *source().compiled));
  exchange(scene.materials, *lights);
  source_ = Source{shared, source_->compiled, std::move(lights)};
  set_view(view_of(scene), settings);
}

const GpuRenderer::Source& GpuRenderer::source() const {
  if (source_) return *source_;
  throw Error(ErrorKind::usage,
              "A renderer of what lies on a device already does not know its materials; make one of the scene.");
}

// The tree and the geometry stay where they are; the tables of materials and lights are small.
void GpuRenderer::exchange(const std::vector<Material>& materials, const CompiledLights& lights) {
  if (const std::string complaint = exchange_complaint(source().scene.scene().materials, materials); !complaint.empty())
    throw Error(ErrorKind::usage, fmt::format("The materials cannot be exchanged: {}.", complaint));
  Diagnostics diagnostics;
  check_materials(materials, diagnostics);
  diagnostics.throw_first_error();
  const CompiledScene& compiled = *source().compiled;
  scene_ = std::make_shared<const DeviceScene>(*scene_, compiled,
                                               compile_materials(materials, compiled.textures.features != 0), lights);
}

// Kernels are kept, whatever constants they were built for, and so are the film and its bindings.
void GpuRenderer::set_scene(const SharedScene& shared, const RenderSettings& settings) {
  const std::shared_ptr<GpuDevice> device = scene_->device_pointer();
  const DeviceScene::Layouts layouts = scene_->layouts();
  source_.reset();  // before the next scene takes memory
  scene_.reset();
  Made made = make_device_scene(device, shared, options_, layouts);
  timings_ = made.timings;
  source_ = Source{shared, made.compiled, made.compiled};
  scene_ = std::move(made.scene);
  if (scene_->layouts() != layouts) {
    forget_film();
    render_kernels_.clear();
    constants_.clear();
    kernels_ = kernel_set(options_, scene_->loads());
  }
  set_view(view_of(shared.scene()), settings);
}

// The constants of the view, of the scene, and of the kernels themselves.
void GpuRenderer::use_constants() {
  std::vector<vulkan::Specialization> constants = view_constants_;
  for (const auto& more : {scene_->constants(), kernels_.constants})
    constants.insert(constants.end(), more.begin(), more.end());
  if (constants == constants_) return;
  constants_ = std::move(constants);
  path_kernel_ = {};
  tracer_.reset();
}

std::vector<vulkan::Specialization> GpuRenderer::view_constants(const View& view, const RenderSettings& settings,
                                                                const CompiledView& compiled) const {
  const SceneFacts& facts = scene_->facts();
  const bool lit = facts.light_instance_count > 0 || facts.distant_light_count > 0 ||
                   facts.environment.kind != gpu::kEnvironmentNone;
  const bool nee = samples_lights(view.integrator) && lit;
  const bool shadow_rays = nee || traces_occlusion(view.integrator.type);
  const std::uint32_t turns = shadow_rays ? kTurnsNee : kTurnsNaive;
  const std::uint32_t steps_nee = is_plain(scene_->constants()) ? kStepsNee : kStepsNeeDear;
  const std::uint32_t steps = !scene_->has_tree() ? 1 : shadow_rays ? steps_nee : kStepsNaive;
  const std::uint32_t tree_depth = samples_lights(view.integrator) ? scene_->light_tree_depth() : 0;
  const LoopRounds& rounds = scene_->loop_rounds();
  const bool light = gathers_light(view.integrator);
  const bool follows_light = light || view.integrator.type == Integrator::Type::aov;
  return {{gpu::kConstantFilterKind, compiled.filter},
          {gpu::kConstantCamera, compiled.camera},
          {gpu::kConstantCameraWindow, compiled.window ? 1u : 0u},
          {gpu::kConstantIntegrator, compiled.integrator},
          {gpu::kConstantNee, nee ? 1u : 0u},
          {gpu::kConstantMis, weighs_strategies(view.integrator) ? 1u : 0u},
          {gpu::kConstantHideEmitters, follows_light && view.integrator.hide_emitters ? 1u : 0u},
          {gpu::kConstantHideBackground, follows_light && view.integrator.hide_background ? 1u : 0u},
          {gpu::kConstantLightPart, light ? compiled.light_part : gpu::kLightPartAll},
          {gpu::kConstantCountPasses, counts_passes(view.integrator) ? 1u : 0u},
          {gpu::kConstantLuminance, settings.quantity == FilmQuantity::luminance ? 1u : 0u},
          {gpu::kConstantStepsPerTurn, steps},
          {gpu::kConstantTurnsPerRound, turns},
          {gpu::kConstantIterationsPerRound, turns * (steps + 1) + 1 + rounds.instances + rounds.primitives +
                                                 2 * tree_depth + rounds.environment_rows + rounds.environment_columns +
                                                 rounds.distant + rounds.materials},
          {gpu::kConstantLightTreeDepth, tree_depth},
          {gpu::kConstantSetBits, set_bits_}};
}

// The film's memory on the device is kept from render to render.
void GpuRenderer::prepare_film(const SlotLayout& slots) {
  if (!film_ || !film_->fits(slots, set_bits_)) {
    forget_film();  // before the next one takes memory
    samples_ = {context(), most_samples(context(), lane_groups_) * sizeof(gpu::vec4),
                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Buffer::Memory::device, "samples"};
    film_ = std::make_unique<DeviceFilm>(scene_->device_pointer(), slots, set_bits_);
    for (const FilmBand& band : film_->bands()) film_sets_.push_back(make_film_set(band, samples_));
  }
  film_->begin();
}

void GpuRenderer::check_film(const Film& film) const {
  if (film.width() == frame_.width && film.height() == frame_.height && film.exponent() == frame_.film_exponent) return;
  throw Error(
      ErrorKind::usage,
      fmt::format("The film is {}x{} pixels of exponent {}, but the view has {}x{} of exponent {}; give both "
                  "the same.",
                  film.width(), film.height(), film.exponent(), frame_.width, frame_.height, frame_.film_exponent));
}

gpu::ReportHead GpuRenderer::take_report() {
  gpu::ReportHead head;
  std::memcpy(&head, report_.mapped().data(), sizeof head);
  const std::uint32_t listed = std::min(head.rejected_count, gpu::kRejectedListed);
  for (std::uint32_t i = 0; i < listed && rejected_.size() < gpu::kRejectedListed; ++i) {
    gpu::RejectedEntry entry;
    std::memcpy(&entry, report_.mapped().data() + sizeof head + i * sizeof entry, sizeof entry);
    rejected_.push_back({{entry.pixel, entry.sample_index}, entry.segments});
  }
  std::memset(report_.mapped().data(), 0, sizeof head);
  return head;
}

// Traces the paths of a chunk: dispatches until every lane has done its share.
void GpuRenderer::trace_chunk(const Work& work, gpu::Pass pass) {
  RenderKernel& present = present_kernel();
  pass.step_budget = step_budget_;
  const std::uint32_t lane_groups = present.sizer.lane_groups(pass.group_count);
  for (double seconds = 0.0;; pass.resume = 1) {
    const double more = dispatch(work, pass, lane_groups);
    const gpu::ReportHead head = take_report();
    if (present.dispatched) {
      ++timings_.dispatches;
      timings_.longest = std::max(timings_.longest, more);
      timings_.render += more;
      seconds += more;
    } else {
      timings_.pipeline += more;  // dominated by the driver's lazy compilation
      present.dispatched = true;
    }
    if (head.unfinished == 0) return present.sizer.measured({pass.first_group, pass.group_count}, pass.paths, seconds);
    if (head.stuck > 0) {
      throw Error(
          ErrorKind::scene,
          fmt::format("{} paths take more than {} steps each, the most '{}' allows. Either thousands of surfaces "
                      "overlap where they pass (`etendue check` names such places): thin them out; or paths are "
                      "endless: lower maxDepth or let roulette begin earlier (rrDepth).",
                      head.stuck, pass.step_budget, context().info().name));
    }
    if (pass.resume == 0) present.sizer.shorten();
  }
}

gpu::Pass GpuRenderer::begin_pass(const SlotLayout& slots, SampleRange range) const {
  return {.first_set = range.begin,
          .sets = range.count(),
          .slots_per_pixel = slots.layers,
          .packed_pixels = slots.packed() ? slots.pixels() : 0};
}

// Renders the next paths of every slot of a band.
void GpuRenderer::run_pass(std::size_t band, gpu::Pass pass, std::uint32_t paths) {
  const RenderKernel& kernel = present_kernel();
  const KernelBindings& layout = scene_->film_kernels();
  const std::uint32_t groups = film_->bands()[band].group_count();
  const std::uint32_t paths_before = pass.paths_before;
  for (std::uint32_t done = 0; done < groups; done += pass.group_count) {
    pass.first_slot = done * gpu::kWorkgroupSize;
    pass.first_group = film_->bands()[band].first_group() + done;
    pass.group_count = kernel.sizer.groups({pass.first_group, groups - done}, paths);
    for (std::uint32_t done_paths = 0; done_paths < paths; done_paths += pass.paths) {
      pass.paths = kernel.sizer.paths(paths - done_paths, {pass.first_group, pass.group_count});
      pass.paths_before = paths_before + done_paths;
      trace_chunk({layout, kernel.trace, film_sets_[band]}, pass);
      timings_.render += dispatch({layout, kernel.take, film_sets_[band]}, pass, pass.group_count);
      take_report();
    }
  }
}

GpuRenderer::RenderKernel& GpuRenderer::present_kernel() {
  constexpr std::size_t kKept = 4;  // picture, AOVs known where rays arrive, direct and indirect light
  const auto found = std::ranges::find(render_kernels_, constants_, &RenderKernel::constants);
  if (found != render_kernels_.end()) return *found;
  if (render_kernels_.size() == kKept) render_kernels_.pop_front();
  return render_kernels_.emplace_back(RenderKernel{
      .constants = constants_,
      .sizer =
          PassSizer(pass_limits(context(), options_, lane_groups_, step_budget_ / iterations_per_round(constants_)))});
}

// Constants and layouts are those of the renderer's own device, whose driver may have no such statistics.
std::vector<KernelReport> GpuRenderer::kernels(const vulkan::Context& compiler) const {
  const vulkan::SetLayout scene(compiler, scene_bindings(scene_->loads(), scene_->queries()));
  const KernelBindings layout(compiler, scene, film_bindings());
  const auto compiled = [&](std::span<const std::uint32_t> spirv, const char* name) {
    return KernelReport{name, vulkan::Kernel(compiler, layout.pipeline, spirv, constants_, name).statistics(compiler)};
  };
  return {compiled(is_plain(constants_) ? kernels_.render_plain : kernels_.render, "render"),
          compiled(kernels_.take_samples, "take_samples")};
}

// Adds the counts of each path to its pixel.
void add_profile(RenderProfile& profile, const gpu::PathProfile& path, std::uint32_t pixel, glm::dvec4& shares) {
  const auto add = [](RayCounts& counts, const gpu::uvec4& more) {
    counts.rays += more.x;
    counts.nodes += more.y;
    counts.primitives += more.z;
  };
  add(profile.camera, path.camera);
  add(profile.scattered, path.scattered);
  add(profile.shadow, path.shadow);
  const gpu::uvec4 all = path.camera + path.scattered + path.shadow;
  profile.visits[pixel] += glm::vec3(all.y, all.z, all.x) / static_cast<float>(profile.samples);
  shares += glm::dvec4(path.shares);
}

RenderProfile GpuRenderer::profile(std::uint32_t samples) {
  if (scene_->queries())
    throw Error(ErrorKind::usage,
                "What rays visit is counted in the tree, and a driver does not tell what it visits; count with "
                "--traversal tree.");
  const GpuTimings of_renders = timings_;
  const KernelBindings& layout = scene_->film_kernels();
  const bool ballots = context().info().subgroup_ballot;
  const vulkan::Kernel kernel =
      make_kernel(layout, ballots ? kernels_.profile_subgroups : kernels_.profile, "render_profile");
  const SlotLayout slots(frame_.width, frame_.height, samples, 1);  // one slot a pixel
  RenderProfile out{.width = frame_.width, .height = frame_.height, .samples = samples << set_bits_};
  out.visits.resize(slots.pixels());
  glm::dvec4 shares(0.0);
  forget_film();
  DeviceFilm film(scene_->device_pointer(), slots, set_bits_);
  film.begin();
  gpu::Pass pass = begin_pass(slots, {0, samples});
  pass.paths = out.samples;
  for (const FilmBand& band : film.bands()) {
    const std::uint32_t most_groups =
        std::min(present_kernel().sizer.groups({band.first_group(), band.group_count()}, pass.paths),
                 most_profiled(context(), pass.paths));
    std::vector<gpu::PathProfile> counts(std::size_t{most_groups} * pass.paths * gpu::kWorkgroupSize);
    const vulkan::Buffer buffer(context(), counts.size() * sizeof(gpu::PathProfile), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                                vulkan::Buffer::Memory::device, "profile");
    const vulkan::BindingSet set = make_film_set(band, buffer);
    for (std::uint32_t done = 0; done < band.group_count(); done += pass.group_count) {
      pass.first_slot = done * gpu::kWorkgroupSize;
      pass.first_group = band.first_group() + done;
      pass.group_count = std::min(most_groups, band.group_count() - done);
      trace_chunk({layout, kernel, set}, pass);
      commands().download(buffer, 0, std::as_writable_bytes(std::span(counts)));
      for (std::size_t i = 0; i < std::size_t{pass.group_count} * pass.paths * gpu::kWorkgroupSize; ++i) {
        const std::uint32_t pixel = slots.pixel(band.first_group() + done + i / (pass.paths * gpu::kWorkgroupSize),
                                                static_cast<std::uint32_t>(i % gpu::kWorkgroupSize));
        if (pixel != ~0u) add_profile(out, counts[i], pixel, shares);
      }
    }
  }
  const double size = context().info().subgroup_size;
  if (shares.x > 0.0) out.walk_utilisation = shares.y / (shares.x * size);
  if (shares.z > 0.0) out.shade_utilisation = shares.w / (shares.z * size);
  timings_ = of_renders;  // counting is not a render
  return out;
}

std::uint32_t GpuRenderer::render(SampleRange range, Film& film, const Progress& progress,
                                  std::vector<RejectedSample>& rejected) {
  check_film(film);
  RenderKernel& present = present_kernel();
  if (!present.trace.get()) {
    const KernelBindings& layout = scene_->film_kernels();
    present.trace = make_kernel(layout, is_plain(constants_) ? kernels_.render_plain : kernels_.render, "render");
    present.take = make_kernel(layout, kernels_.take_samples, "take_samples");
  }
  rejected_.clear();
  const SlotLayout slots(frame_.width, frame_.height, range.count(), wanted_slots(context()));
  prepare_film(slots);
  const std::uint64_t pixels = std::uint64_t{frame_.width} * frame_.height;
  std::uint32_t done = range.begin;
  gpu::Pass pass = begin_pass(slots, range);
  bool go_on = true;
  while (done < range.end && go_on) {
    const std::uint64_t left = range.end - done;
    const std::uint64_t left_a_slot = (left + slots.layers - 1) / slots.layers;
    const auto samples = static_cast<std::uint32_t>(std::min<std::uint64_t>(
        present.sizer.samples(slots.groups() * gpu::kWorkgroupSize, 1u << set_bits_), left_a_slot));
    const std::uint32_t end = done + static_cast<std::uint32_t>(std::min(std::uint64_t{samples} * slots.layers, left));
    pass.sets = end - range.begin;
    for (std::size_t i = 0; i < film_sets_.size(); ++i) run_pass(i, pass, samples << set_bits_);
    pass.paths_before += samples << set_bits_;
    ++timings_.passes;
    done = end;
    if (progress) go_on = progress((done - range.begin) * pixels, range.count() * pixels);
  }
  film_->add_to(film);
  rejected.insert(rejected.end(), rejected_.begin(), rejected_.end());
  return done;
}

std::vector<SampleRecord> GpuRenderer::trace_samples(std::span<const SampleId> ids) {
  constexpr std::size_t kChunk = 1u << 16;
  if (!tracer_) tracer_ = std::make_unique<SampleTracer>(*this, kChunk);
  std::vector<SampleRecord> out;
  out.reserve(ids.size());
  for (std::size_t first = 0; first < ids.size(); first += kChunk) {
    const auto chunk = ids.subspan(first, std::min(kChunk, ids.size() - first));
    std::vector<gpu::SampleResult> results =
        tracer_->trace(chunk, context().is_cpu() ? kCpuIterationsDivergent : kGpuIterations);
    for (std::size_t i = 0; i < results.size(); ++i) {
      // A long path is traced again alone, with the whole budget to itself.
      if (results[i].stuck != 0) results[i] = tracer_->trace(chunk.subspan(i, 1), step_budget_).front();
      if (results[i].stuck != 0) {
        throw Error(
            ErrorKind::scene,
            fmt::format("The path of pixel {} sample {} takes more than {} steps: thousands of surfaces overlap "
                        "where it passes (`etendue check` names such places), or it is endless; thin them out "
                        "or lower maxDepth.",
                        chunk[i].pixel, chunk[i].sample, step_budget_));
      }
      out.push_back({results[i].radiance, results[i].signature, results[i].segments});
    }
  }
  return out;
}

std::vector<PathVertex> GpuRenderer::trace_path(SampleId id) {
  if (!path_kernel_.get())
    path_kernel_ = make_request_kernel(kernels_.trace_path_plain, kernels_.trace_path, "trace_path");
  const vulkan::Buffer request(context(), sizeof(gpu::SampleRequest), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
                               vulkan::Buffer::Memory::device, "sample request");
  constexpr std::size_t kBytes = 16 + gpu::kMaxTracedVertices * sizeof(gpu::TracedVertex);
  const vulkan::Buffer vertices(context(), kBytes, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, vulkan::Buffer::Memory::device,
                                "path vertices");
  const gpu::SampleRequest asked{id.pixel, id.sample, 0, 0};
  commands().upload(request, 0, std::as_bytes(std::span(&asked, 1)));
  const vulkan::BindingSet set = make_request_set(request, vertices);
  gpu::Pass pass{};
  pass.step_budget = step_budget_;
  dispatch({scene_->request_kernels(), path_kernel_, set}, pass, 1);
  std::vector<std::byte> bytes(kBytes);
  commands().download(vertices, 0, bytes);
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data(), sizeof count);
  const Normalization& normalization = scene_->facts().normalization;
  const auto in_world = [&](const glm::vec3& p) {
    return glm::vec3(glm::dvec3(p) / normalization.scale + normalization.center);
  };
  std::vector<PathVertex> out;
  for (std::uint32_t i = 0; i < std::min(count, gpu::kMaxTracedVertices); ++i) {
    gpu::TracedVertex v;
    std::memcpy(&v, bytes.data() + 16 + i * sizeof v, sizeof v);
    const bool met = v.instance != gpu::kNone;
    out.push_back({v.instance, v.primitive, v.light_instance, v.light_primitive, v.light_contributed, v.lobe,
                   v.survived, in_world(v.from), met ? in_world(v.to) : v.to, v.radiance});
  }
  return out;
}

}  // namespace

std::unique_ptr<Renderer> make_gpu_renderer(const SharedScene& shared, const RenderSettings& settings,
                                            const GpuOptions& options) {
  Made made = make_device_scene(open_device(options), shared, options);
  return std::make_unique<GpuRenderer>(std::move(made.scene), GpuRenderer::Source{shared, std::move(made.compiled)},
                                       view_of(shared.scene()), settings, options, made.timings);
}

std::unique_ptr<Renderer> make_gpu_renderer(std::shared_ptr<const DeviceScene> scene, const View& view,
                                            const RenderSettings& settings, const GpuOptions& options) {
  return std::make_unique<GpuRenderer>(std::move(scene), std::nullopt, view, settings, options, GpuTimings{});
}

GpuTimings gpu_timings(const Renderer& renderer) {
  return dynamic_cast<const GpuRenderer&>(renderer).timings();
}
RenderProfile gpu_profile(Renderer& renderer, std::uint32_t samples) {
  return dynamic_cast<GpuRenderer&>(renderer).profile(samples);
}
std::vector<KernelReport> gpu_kernels(const Renderer& renderer, const vulkan::Context& compiler) {
  return dynamic_cast<const GpuRenderer&>(renderer).kernels(compiler);
}
std::string gpu_device_choice(const Renderer& renderer) {
  return dynamic_cast<const GpuRenderer&>(renderer).choice();
}

}  // namespace etendue
