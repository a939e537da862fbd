#pragma once
/// Renderers and renders.
///
/// render() does a whole job: it opens one or several devices, renders, writes checkpoints, and returns the film.
/// open_renderer() opens one device for programs that request samples themselves.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "image/film_file.h"
#include "render/film_identity.h"
#include "render/renderer.h"
#include "render/session.h"
#include "render/shared_scene.h"
#include "render/traversal.h"
#include "scene/scene.h"
#include "validate/renderer_factory.h"

namespace etendue {

/// A Vulkan device of this machine.
struct DeviceDescription {
  std::string name;
  std::string type;          ///< "discrete GPU", "CPU", …
  std::string driver;        ///< name and version
  std::string missing;       ///< why it cannot render; empty if it can
  bool ray_queries = false;  ///< whether Traversal::query works there
};

/// All devices, in the order of their numbers. Throws Error(device) if there is no Vulkan loader.
std::vector<DeviceDescription> list_devices();

/// Where to render.
struct DeviceSelection {
  /// "auto"; the number of a device or a part of its name; "reference", the double-precision renderer on the host;
  /// numbers separated by commas, or "all", for several devices that share the work.
  std::string selector = "auto";
  std::optional<double> max_wait_seconds{};  ///< a device whose dispatch takes longer counts as hanging
  /// Longest that a dispatch should take; empty: 0.1 on GPUs, 1 on CPUs.
  std::optional<double> dispatch_seconds{};
  std::uint32_t pass_samples = 0;  ///< not 0: samples of each lane per dispatch, for tests
  /// Who finds what rays meet on Vulkan devices. `query` makes opening a device without ray queries an Error(device),
  /// and is an Error(usage) for the reference.
  Traversal traversal = Traversal::automatic;
};

/// Factories for renderers, one for each selected device. Throws Error(device) if "all" finds none; a factory throws
/// whatever opening its device throws.
std::vector<RendererFactory> renderer_factories(const DeviceSelection& devices);

/// Opens one device with a scene, which must outlive the renderer. If the same `SharedScene` is passed to several
/// calls, it is compiled only once. Throws Error(usage) if the selector names several devices, Error(scene) for a scene
/// that violates an invariant (scene/invariants.h), Error(device, lost).
std::unique_ptr<Renderer> open_renderer(const SharedScene& scene, const DeviceSelection& device = {},
                                        const RenderSettings& settings = {});

/// A job for render().
struct RenderRequest {
  DeviceSelection devices;
  std::uint32_t seed = 0;
  std::uint32_t samples = 0;  ///< paths per pixel, rounded up to whole sets; 0: as in the scene
  std::uint32_t first = 0;    ///< first path, at the start of a set; for pieces to be merged (image/merge.h)
  std::optional<std::vector<Aov>> aovs{};  ///< beside the picture; nothing: those that the scene asks for
  std::string checkpoint{};                ///< film file for the samples rendered so far; empty: none
  std::optional<FilmFile> start{};         ///< continues this film of the same render
  SessionOptions session{};                ///< budgets; its set_size is taken from the scene
  SessionHooks hooks{};                    ///< progress, and requests to stop
};

/// Renders. The film records which samples it holds: fewer than requested if a budget or a hook ended the render.
/// Throws Error(scene) for a scene that violates an invariant, Error(usage) for an impossible request, Error(device,
/// lost, file) for failures; the checkpoint, if there is one, then holds what was done. The same scene, seed and kind
/// of device give the same bytes, whatever happened during the render.
FilmFile render(const SharedScene& scene, const RenderRequest& request = {});

/// A render in steps, between which the film can be inspected and devices stay open. After each step the film is byte
/// for byte the one that render() gives for the same number of samples.
class ProgressiveRender {
 public:
  /// Opens the devices. Throws what render() throws.
  ProgressiveRender(const SharedScene& scene, RenderRequest request);
  ~ProgressiveRender();
  ProgressiveRender(const ProgressiveRender&) = delete;
  ProgressiveRender& operator=(const ProgressiveRender&) = delete;

  /// Continues until the film holds `samples` paths per pixel, rounded up to whole sets and at most those of the
  /// request, or until a budget or a hook ends the step. Throws like render(); the film then holds what was done.
  SessionEnd advance(std::uint32_t samples);
  /// Continues to the end of the request.
  SessionEnd finish();
  /// The film so far.
  const FilmFile& film() const;
  /// Paths per pixel: in the film, and in the whole request.
  std::uint64_t done() const;
  std::uint64_t total() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace etendue
