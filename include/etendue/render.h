#pragma once
/// Renderers and renders.
///
/// render() does a whole job: it opens one or several devices, renders, keeps a checkpoint, and returns the film.
/// open_renderer() opens one device for a program that wants to ask for samples itself.

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
#include "scene/scene.h"
#include "validate/renderer_factory.h"

namespace etendue {

/// A Vulkan device of this machine.
struct DeviceDescription {
  std::string name;
  std::string type;     ///< "discrete GPU", "CPU", …
  std::string driver;   ///< name and version
  std::string missing;  ///< why it cannot render; empty: it can
};

/// All of them, in the order of their numbers. Throws Error(device) when there is no Vulkan loader.
std::vector<DeviceDescription> list_devices();

/// Where to render.
struct DeviceSelection {
  /// "auto"; the number of a device or a part of its name; "reference": the double-precision renderer on the host;
  /// numbers with commas between them, or "all": several devices that share the work.
  std::string selector = "auto";
  std::optional<double> max_wait_seconds{};  ///< a dispatch that takes longer means that the device hangs
  std::uint32_t pass_samples = 0;            ///< not 0: samples of each lane per dispatch, for tests
};

/// Makers of renderers, one for each device selected. Throws Error(device) when "all" finds none; a maker throws what
/// opening its device throws.
std::vector<RendererFactory> renderer_factories(const DeviceSelection& devices);

/// Opens one device with a scene, which must outlive the renderer. Give a `SharedScene` to several calls, and what is
/// compiled of the scene is compiled once. Throws Error(usage) when the selector names several devices, Error(scene)
/// for a scene that breaks an invariant (scene/invariants.h), Error(device, lost).
std::unique_ptr<Renderer> open_renderer(const SharedScene& scene, const DeviceSelection& device = {},
                                        const RenderSettings& settings = {});

/// A job for render().
struct RenderRequest {
  DeviceSelection devices;
  std::uint32_t seed = 0;
  std::uint32_t samples = 0;  ///< paths a pixel, rounded up to whole sets; 0: as many as the scene says
  std::uint32_t first = 0;    ///< path to begin with, of a whole set: for pieces that are merged (image/merge.h)
  std::optional<std::vector<Aov>> aovs{};  ///< beside the picture; nothing: those that the scene asks for
  std::string checkpoint{};                ///< film file that keeps what is done; empty: none
  std::optional<FilmFile> start{};         ///< goes on from this film, of the same render
  SessionOptions session{};                ///< budgets; its set_size is taken from the scene
  SessionHooks hooks{};                    ///< progress, and requests to stop
};

/// Renders. The film says which samples it holds: fewer than asked for when a budget or a hook ended the render. Throws
/// Error(scene) for a scene that breaks an invariant, Error(usage) for a request that cannot be met, Error(device,
/// lost, file) for what fails; the checkpoint, if there is one, then holds what was done. The same scene, seed and kind
/// of device give the same bytes, whatever happened on the way.
FilmFile render(const SharedScene& scene, const RenderRequest& request = {});

/// A render in steps that are looked at: devices stay open between them. After each step the film is the one that
/// render() gives for as many samples, to the byte.
class ProgressiveRender {
 public:
  /// Opens the devices. Throws what render() throws.
  ProgressiveRender(const SharedScene& scene, RenderRequest request);
  ~ProgressiveRender();
  ProgressiveRender(const ProgressiveRender&) = delete;
  ProgressiveRender& operator=(const ProgressiveRender&) = delete;

  /// Renders on until the film holds `samples` paths a pixel, rounded up to whole sets, at most all of the request's;
  /// or until a budget or a hook ends the step. Throws like render(); the film then holds what was done.
  SessionEnd advance(std::uint32_t samples);
  /// The same to the end of the request.
  SessionEnd finish();
  /// What is done.
  const FilmFile& film() const;
  /// Paths a pixel: in the film, and of the whole request.
  std::uint64_t done() const;
  std::uint64_t total() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace etendue
