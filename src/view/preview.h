#pragma once
/// A render controlled while it runs: one thread renders, others look at its pictures and request changes. After a
/// change there is soon a coarse picture, then a finer one, to which samples are then added.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/read_log.h"
#include "etendue/render.h"
#include "image/tone_mapping.h"
#include "scene/light_sources.h"
#include "view/picture.h"
#include "view/pose.h"

namespace etendue::view {

struct PreviewOptions {
  std::function<Scene()> read_scene;  ///< throws Error; called again for every reload
  DeviceSelection device;
  /// Opens a renderer in place of open_renderer() with that device.
  std::function<std::unique_ptr<Renderer>(const SharedScene&, const RenderSettings&)> open = {};
  std::uint32_t seed = 0;
  std::uint32_t samples = 0;                   ///< paths per pixel after which it rests; 0: as many as in the scene
  std::chrono::milliseconds unwatched{60000};  ///< it rests if nobody has looked for so long
};

enum class Phase { opening, rendering, resting, done, stopped };

/// A part of the film, in pixels from the top left.
struct Crop {
  std::uint32_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Crop&) const = default;
};

/// Everything that can be looked at. Pictures are shared and never change.
struct State {
  std::uint64_t version = 0;            ///< grows with every change to any member
  std::uint64_t picture = 0;            ///< grows with every new picture; 0: there is none yet
  std::uint32_t width = 0, height = 0;  ///< of the picture
  std::optional<Crop> crop;             ///< the part that is rendered; nothing: the whole film
  std::uint32_t full_width = 0,
                full_height =
                    0;  ///< of the film, or of the crop; above `width` and `height` while the picture is coarse
  Bytes mean, error;    ///< `error` is empty unless somebody asked for it
  std::uint64_t samples = 0, target = 0;  ///< paths a pixel
  double samples_per_second = 0;          ///< of all pixels
  double relative_error = 0;              ///< see relative_standard_error; infinite while unknown
  double seconds_left = 0;                ///< infinite while unknown
  std::uint64_t rejected = 0;
  Phase phase = Phase::opening;
  bool paused = false;
  std::string problem;  ///< a sentence on why the picture is not the one requested; empty if it is
  std::string scene, file, device, driver;
  std::uint64_t loads = 0;  ///< how often the scene was read without an error
  Camera camera;            ///< as it is now, for the full size
  Pose pose;
  std::uint64_t mover = 0;  ///< who moved it last, as passed to `move`
  Integrator integrator;
  std::map<std::string, std::shared_ptr<const Layer>> layers;  ///< those of the requested AOVs, by name
  std::uint64_t materials = 0;                                 ///< grows with every change to them that is rendered
  std::uint64_t lights = 0;                                    ///< likewise
};

/// The materials and lights, and the scene they come from. Never modified, only replaced.
struct Palette {
  std::shared_ptr<const Scene> scene;                      ///< as read
  std::shared_ptr<const std::vector<Material>> materials;  ///< as they are now
  std::shared_ptr<const LightSources> lights;              ///< likewise
};

/// What a viewer wants to see besides the mean.
struct Looked {
  bool error = false;
  std::optional<Aov> aov;
};

/// The surface point that a pixel's first sample hits.
struct Point {
  bool hit = false;
  glm::dvec3 position{0.0};            ///< world space
  double focus = 0.0;                  ///< depth of the point along the camera's +Z, camera units
  std::uint32_t material = 0;          ///< row of the scene's materials
  std::optional<std::uint32_t> light;  ///< row of its lights, if the surface emits
};

/// The path of a sample, as reported by a renderer.
struct Told {
  std::string device;
  std::vector<PathVertex> path;
};

/// Changes to an integrator that gathers light.
struct IntegratorChange {
  std::optional<std::uint32_t> max_depth, rr_depth;
  std::optional<bool> nee, mis;
};

/// A new value for a number of a material or a light. No value resets it to the file's; without a name, all numbers of
/// the row are reset.
struct NumberChange {
  std::uint32_t row = 0;
  std::string name;
  std::optional<glm::dvec3> value;
  bool going_on = false;  ///< more moves will follow at once: the picture stays coarse
};

/// A new state of the camera.
struct Move {
  Pose pose;
  double fov = 0;                  ///< degrees; 0: unchanged
  std::optional<double> aperture;  ///< radius, camera units; 0: a pinhole
  std::optional<double> focus;     ///< distance of the plane in focus, camera units
  bool going_on = false;           ///< more moves will follow at once: the picture stays coarse
  std::uint64_t mover = 0;
};

class Preview {
 public:
  /// Begins at once, in a thread of its own. Never throws for errors of the scene or the device; the state reports
  /// them.
  explicit Preview(PreviewOptions options);
  ~Preview();
  Preview(const Preview&) = delete;
  Preview& operator=(const Preview&) = delete;

  /// Returns the state as soon as it is newer than `version`, or when the time runs out or the preview ends. What the
  /// caller wants to see (`looked`) comes with the next pictures.
  State wait(std::uint64_t version, const Looked& looked, std::chrono::milliseconds longest);

  /// If moves arrive faster than pictures, only the last one counts. The same holds for all changes below.
  void move(const Move& move);
  /// Returns to the scene's own camera.
  void reset_camera();
  void set_samples(std::uint32_t samples);
  /// Renders only that part of the film, clipped to the film; nothing: all of it.
  void set_crop(const std::optional<Crop>& crop);
  /// Lasts until the scene is read again. The scene is not recompiled.
  void change(const IntegratorChange& change);
  /// The same for the numbers of a material, see scene/material_numbers.h; of a number with a texture, the factor that
  /// the texture is multiplied with. Throws Error(usage) if there is no such number, and Error(scene) with the sentence
  /// of check_materials() if the value is out of range.
  void change(const NumberChange& change);
  /// The same for the numbers of a light, see scene/light_sources.h.
  void change_light(const NumberChange& change);
  /// Empty until a scene has been read.
  Palette palette() const;
  void set_paused(bool paused);
  /// Reads the scene again.
  void reload();

  /// The bytes of the .exr or .png file that `etendue render` would write for the picture. Throws Error(usage) while
  /// the picture is coarse.
  std::string snapshot(const std::string& extension, const Display& display = {});

  /// The surface at a pixel of the full film, with 0,0 at the top left. Throws Error(usage) outside the film.
  Point point_at(std::uint32_t x, std::uint32_t y);
  /// The path of a sample of a pixel, traced by the device (which compiles a kernel for the first one) or by the
  /// reference. Both throw like point_at.
  Told explain(std::uint32_t x, std::uint32_t y, std::uint32_t sample);
  Told explain_by_reference(std::uint32_t x, std::uint32_t y, std::uint32_t sample);

  /// The files from which the scene was read, as they were then.
  FileStamps files() const;
  /// Ends all waiting; later calls return at once.
  void stop();

 private:
  using Clock = std::chrono::steady_clock;
  using Edit = std::function<void()>;
  struct Opened;  // a scene and what renders it

  void run();
  bool run_edits(bool wait);
  bool has_work();
  bool is_done() const;
  void load();
  std::unique_ptr<Renderer> open_renderer_of(const SharedScene& scene) const;
  std::unique_ptr<Opened> open(std::shared_ptr<const Scene> scene);
  void open_again();
  void edit(const std::string& kind, Edit edit);
  template <class Result>
  Result ask(std::function<Result()> question);
  void answer_questions();
  void take_own_camera();
  void take_numbers(bool going_on);
  void set_lights(std::shared_ptr<const Scene> scene);
  void restart();
  void go_on();
  void work();
  void begin(std::uint32_t scale);
  View full_view() const;
  View present_view() const;
  // A sample, and what it is one of.
  struct Subject {
    Palette palette;
    View view;
    SampleId id;
  };
  Subject subject_of(std::uint32_t x, std::uint32_t y, std::uint32_t sample) const;
  Renderer& reference_of(const Palette& palette);
  SampleId id_of(std::uint32_t x, std::uint32_t y, std::uint32_t sample) const;
  void add_layers();
  std::set<Aov> wanted_layers();
  void add_layer(Aov aov);
  std::uint32_t first_scale() const;
  std::uint32_t next_scale() const;
  std::uint32_t round_samples() const;
  bool wants_picture() const;
  void publish();
  void tell(Phase phase);
  void fail(const std::string& sentence);
  std::uint32_t target_sets() const;
  Camera camera() const;
  Camera film_camera() const;
  std::string write_snapshot(const std::string& extension, const Display& display);

  PreviewOptions options_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;    // wakes those waiting for a new state
  std::condition_variable wake_;       // wakes the rendering thread
  State state_;                        // guarded, like the next seven
  std::map<std::string, Edit> edits_;  // the last one of each kind
  std::vector<std::function<void()>> questions_;
  FileStamps files_;
  Palette palette_;
  Clock::time_point looked_at_ = Clock::now();
  Clock::time_point error_wanted_{};
  std::map<Aov, Clock::time_point> layers_wanted_;
  std::atomic<bool> stopping_{false}, interrupted_{false};

  // Used by the rendering thread only.
  std::unique_ptr<Opened> opened_;
  Pose pose_;
  double fov_ = 0;
  Aperture aperture_;
  std::optional<Crop> crop_;  // inside the film
  Integrator integrator_;
  std::uint64_t layers_made_ = 0;
  bool moved_ = false;
  std::uint64_t mover_ = 0;
  Clock::time_point moving_until_{};
  std::uint32_t samples_ = 0;  // requested; 0: the scene's
  bool paused_ = false;
  std::uint32_t scale_ = 0;  // width in film pixels of a pixel of the picture; 0: not begun
  Film film_;
  std::uint32_t done_ = 0;  // film samples
  double rate_ = 2e5;       // pixel samples per second; the first guess is cautious
  double relative_error_ = 0, error_seconds_ = 0;
  Clock::time_point begun_{}, published_{}, error_known_{};
  std::uint32_t published_done_ = 0;
  double publishing_seconds_ = 0;

  // The reference traces a sample in the thread that asks for it, one at a time.
  std::mutex reference_mutex_;
  Palette reference_palette_;
  std::unique_ptr<Renderer> reference_;

  std::thread thread_;
};

}  // namespace etendue::view
