#pragma once
/// One or several devices that render a job together, and survive the loss of a device.

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "image/film_file.h"
#include "render/renderer.h"
#include "render/sample_queue.h"

namespace etendue {

/// Opens a renderer of the job's scene on one device; called again if that device is lost.
using OpenRenderer = std::function<std::unique_ptr<Renderer>()>;

/// The AOVs to render, from the same samples.
struct AovPlan {
  View view;  ///< the picture's
  RenderSettings settings;
  std::vector<AovHeader> aovs;
};

/// Samples that one device has finished.
struct FinishedSamples {
  SampleRange range;
  const Film* film = nullptr;                  ///< exactly these samples of every pixel
  const std::vector<AovFilm>* aovs = nullptr;  ///< for AOVs that are not averaged, the first of them
  const Renderer* renderer = nullptr;
  const std::vector<RejectedSample>* rejected = nullptr;
};

class DeviceTeam {
 public:
  /// Number of attempts to reopen a lost device before it is given up. The count restarts when samples are finished.
  static constexpr int kRetries = 3;

  /// Opens every device.
  explicit DeviceTeam(std::vector<OpenRenderer> open, AovPlan aovs = {});

  /// Renders the queue until it is empty, or until `go_on` returns false; samples that were taken but not rendered are
  /// then back in the queue. Both functions are called under one lock: `deliver` for finished samples, `go_on` after
  /// every pass with the pixel samples done in this call.
  ///
  /// A lost device (DeviceLost) loses what it had not delivered; it is reopened, and the samples are rendered again. If
  /// one is lost for good, the others take over its work; DeviceLost is thrown if none is left. Any other error ends
  /// the work of all devices after their pass and is thrown.
  void render(SampleQueue& queue, std::uint32_t width, std::uint32_t height, int film_exponent,
              const std::function<void(const FinishedSamples&)>& deliver,
              const std::function<bool(std::uint64_t done)>& go_on);

  /// From now on, renders the same scene from another view, which must already be set in the scene, because a reopened
  /// device uses that.
  void look_at(AovPlan plan);

  /// From now on, renders another scene on the devices that are open. `open` opens renderers of that scene, as many as
  /// before.
  void show(const SharedScene& scene, std::vector<OpenRenderer> open, AovPlan plan);

  /// One renderer per working device.
  std::vector<Renderer*> renderers() const;

 private:
  struct Member {
    OpenRenderer open;
    std::unique_ptr<Renderer> renderer;  ///< null: lost for good
    Film film;                           ///< what it renders into; delivered and cleared
    std::vector<AovFilm> aovs;           ///< likewise
    double samples_per_second = 0;       ///< sample indices, 0 before the first measurement
    int failures = 0;                    ///< since samples were finished last
    std::uint64_t in_flight = 0;         ///< pixel samples done and not delivered
  };
  struct Run;

  void change(AovPlan plan, const std::function<void(Renderer&)>& tell);
  void open_afresh(Member& member, std::string reason);
  void work(Member& member, Run& run);
  SampleRange render_chunk(Member& member, Run& run, SampleRange chunk);
  void render_aovs(Member& member, SampleRange samples);
  std::uint32_t chunk_size(const Member& member, const SampleQueue& queue) const;

  std::vector<Member> members_;
  AovPlan plan_;
};

}  // namespace etendue
