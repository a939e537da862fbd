#include <atomic>
#include <memory>
#include <mutex>

#include "module.h"

namespace etendue::python {
namespace {

/// What render() and Progressive take; the meanings are those of RenderRequest.
struct Options {
  std::uint32_t spp;
  std::uint32_t first;
  std::uint32_t seed;
  std::string device;
  std::optional<double> time;
  std::optional<double> until_error;
  std::optional<double> max_wait;
  std::string checkpoint;
  double checkpoint_every;
  std::shared_ptr<const FilmFile> start;
  std::optional<std::vector<Aov>> aovs;
};

/// A render whose devices stay open, and who wants it to stop.
class Render {
 public:
  Render(SceneHolder& scene, Options options) : scene_(scene.read()), options_(std::move(options)) {}

  /// Opens the devices, if that was not done, and renders until `samples` paths a pixel are there, or all for 0.
  /// Returns what a signal handler or `progress` raised, or None. One thread at a time.
  nb::object advance(std::uint32_t samples, const nb::object& progress) {
    const std::unique_lock only(busy_, std::try_to_lock);
    if (!only.owns_lock())
      throw Error(ErrorKind::usage, "This render is at work in another thread; one at a time may ask it to go on.");
    if (!scene_) throw Error(ErrorKind::usage, "This render is closed.");
    Control control;
    const Scene& scene = scene_->scene();
    const std::uint64_t pixels = std::uint64_t{scene.camera.width} * scene.camera.height;
    control.total = pixels * (options_.spp > 0 ? options_.spp : scene.sampler.sample_count);
    control_ = &control;
    const nb::object raised = run_interruptibly([&] { work(samples); }, control, progress);
    control_ = nullptr;
    return raised;
  }

  /// Lets go of the scene and the devices.
  void close() {
    render_.reset();
    scene_.reset();
  }

  /// The film as it is, which later samples do not change; None before there is any sample.
  std::optional<Picture> picture() const {
    if (!render_ || render_->film().samples.empty()) return std::nullopt;
    return Picture(render_->film());
  }
  std::uint64_t done() const { return render_ ? render_->done() : 0; }
  std::uint64_t total() const { return render_ ? render_->total() : 0; }
  const char* end() const { return to_text(end_); }

 private:
  void work(std::uint32_t samples) {
    if (!render_) render_ = std::make_unique<ProgressiveRender>(*scene_, request());
    end_ = samples > 0 ? render_->advance(samples) : render_->finish();
  }

  RenderRequest request() {
    RenderRequest request;
    request.devices = {.selector = options_.device, .max_wait_seconds = options_.max_wait};
    request.seed = options_.seed;
    request.samples = options_.spp;
    request.first = options_.first;
    request.checkpoint = options_.checkpoint;
    if (options_.start) request.start = *options_.start;
    request.aovs = options_.aovs;
    request.session.checkpoint_seconds = options_.checkpoint_every;
    request.session.time_seconds = options_.time;
    request.session.max_error = options_.until_error;
    request.hooks.stop_asked = [this] { return control_->stop.load(); };
    request.hooks.progress = [this](std::uint64_t done) { control_->done = done; };
    request.hooks.warn = [](const std::string& sentence) { log::warning(sentence); };
    return request;
  }

  std::shared_ptr<const SharedScene> scene_;
  Options options_;
  std::mutex busy_;
  Control* control_ = nullptr;  ///< of the call that is at work; hooks are called during one only
  std::unique_ptr<ProgressiveRender> render_;
  SessionEnd end_ = SessionEnd::interrupted;
};

std::vector<std::tuple<std::string, std::string, std::string, std::string>> devices() {
  std::vector<std::tuple<std::string, std::string, std::string, std::string>> all;
  run_waiting([&] {
    for (const DeviceDescription& device : list_devices())
      all.emplace_back(device.name, device.type, device.driver, device.missing);
  });
  return all;
}

}  // namespace

void bind_renders(nb::module_& m) {
  nb::class_<Render>(m, "Render")
      .def(
          "__init__",
          [](Render* self, SceneHolder& scene, std::uint32_t spp, std::uint32_t first, std::uint32_t seed,
             const std::string& device, std::optional<double> time, std::optional<double> until_error,
             std::optional<double> max_wait, const std::string& checkpoint, double checkpoint_every,
             const std::optional<Picture>& start, const std::optional<std::vector<std::string>>& aovs) {
            if (start && !start->film) throw Error(ErrorKind::usage, "Only from a film can a render go on.");
            new (self)
                Render(scene, {spp, first, seed, device, time, until_error, max_wait, checkpoint, checkpoint_every,
                               start ? start->film : nullptr, aovs ? std::optional(aovs_named(*aovs)) : std::nullopt});
          },
          nb::arg("scene"), nb::kw_only(), nb::arg("spp"), nb::arg("first"), nb::arg("seed"), nb::arg("device"),
          nb::arg("time").none(), nb::arg("until_error").none(), nb::arg("max_wait").none(), nb::arg("checkpoint"),
          nb::arg("checkpoint_every"), nb::arg("start").none(), nb::arg("aovs").none())
      .def("advance", &Render::advance, nb::arg("samples"), nb::arg("progress").none())
      .def("close", &Render::close)
      .def_prop_ro("picture", &Render::picture)
      .def_prop_ro("done", &Render::done)
      .def_prop_ro("total", &Render::total)
      .def_prop_ro("end", &Render::end);
  m.def("devices", &devices);
  m.def("thread_count", &thread_count);
  m.def("set_thread_count", &set_thread_count, nb::arg("count"));
}

}  // namespace etendue::python
