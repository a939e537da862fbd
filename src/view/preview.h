#pragma once
/// A render that is steered while it goes on: one thread renders, others look at what it has and tell it what to
/// change. What is asked first is a coarse picture, soon; then a finer one; then samples are added to it.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/read_log.h"
#include "etendue/render.h"
#include "image/tone_mapping.h"
#include "view/picture.h"
#include "view/pose.h"

namespace etendue::view {

struct PreviewOptions {
  std::function<Scene()> read_scene;  ///< throws Error; called again for every reload
  DeviceSelection device;
  std::uint32_t seed = 0;
  std::uint32_t samples = 0;                   ///< paths a pixel after which it rests; 0: as many as the scene says
  std::chrono::milliseconds unwatched{60000};  ///< after which it rests when nobody looks
};

enum class Phase { opening, rendering, resting, done, stopped };

/// What is there to be looked at. Pictures are shared and never change.
struct State {
  std::uint64_t version = 0;                      ///< grows with every change of any of this
  std::uint64_t picture = 0;                      ///< grows with every new picture; 0: there is none yet
  std::uint32_t width = 0, height = 0;            ///< of the picture
  std::uint32_t full_width = 0, full_height = 0;  ///< of the film; more than that while the picture is coarse
  Bytes mean, error;                              ///< `error` is empty when nobody asked for it
  std::uint64_t samples = 0, target = 0;          ///< paths a pixel
  double samples_per_second = 0;                  ///< of all pixels
  double relative_error = 0;                      ///< see relative_standard_error; infinite while it is not known
  double seconds_left = 0;                        ///< infinite while it is not known
  std::uint64_t rejected = 0;
  Phase phase = Phase::opening;
  bool paused = false;
  std::string problem;  ///< a sentence on why the picture is not the one asked for; empty: it is
  std::string scene, file, device, driver;
  std::uint64_t loads = 0;  ///< times the scene was read without an error
  Camera camera;            ///< as it stands, of the full size
  Pose pose;
  std::uint64_t mover = 0;  ///< who moved it last, as told to `move`
  Integrator integrator;
};

/// How a camera is to stand.
struct Move {
  Pose pose;
  double fov = 0;         ///< degrees; 0: as it is
  bool going_on = false;  ///< more will follow at once: the picture stays coarse
  std::uint64_t mover = 0;
};

class Preview {
 public:
  /// Begins at once, in a thread of its own. Never throws for what the scene or the device does: the state tells it.
  explicit Preview(PreviewOptions options);
  ~Preview();
  Preview(const Preview&) = delete;
  Preview& operator=(const Preview&) = delete;

  /// The state, as soon as it is newer than `version`, or as it is when the time is up or the preview ends. `error`:
  /// whether the caller will look at the standard error, which then comes with the next pictures.
  State wait(std::uint64_t version, bool error, std::chrono::milliseconds longest);

  /// Of several moves that come faster than pictures only the last one counts, and so with all that follows.
  void move(const Move& move);
  /// Back to the scene's own camera.
  void reset_camera();
  void set_samples(std::uint32_t samples);
  void set_paused(bool paused);
  /// Reads the scene again.
  void reload();

  /// The picture as `etendue render` would write it, as the bytes of an .exr or .png file. Throws Error(usage) while it
  /// is coarse.
  std::string snapshot(const std::string& extension, const Display& display = {});

  /// Files that the scene was read from, as they were then.
  FileStamps files() const;
  /// Ends all waiting; calls that come later return at once.
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
  void edit(const std::string& kind, Edit edit);
  template <class Result>
  Result ask(std::function<Result()> question);
  void answer_questions();
  void restart();
  void go_on();
  void work();
  void begin(std::uint32_t scale);
  std::uint32_t first_scale() const;
  std::uint32_t next_scale() const;
  std::uint32_t round_samples() const;
  bool wants_picture() const;
  void publish();
  void tell(Phase phase);
  void fail(const std::string& sentence);
  std::uint32_t target_sets() const;
  Camera camera() const;
  std::string write_snapshot(const std::string& extension, const Display& display);

  PreviewOptions options_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;    // for those who look
  std::condition_variable wake_;       // for the thread that renders
  State state_;                        // guarded, like the next five
  std::map<std::string, Edit> edits_;  // by kind: the last of each
  std::vector<std::function<void()>> questions_;
  FileStamps files_;
  Clock::time_point looked_at_ = Clock::now();
  Clock::time_point error_wanted_{};
  std::atomic<bool> stopping_{false}, interrupted_{false};

  // Of the rendering thread alone.
  std::unique_ptr<Opened> opened_;
  Pose pose_;
  double fov_ = 0;
  bool moved_ = false;
  std::uint64_t mover_ = 0;
  Clock::time_point moving_until_{};
  std::uint32_t samples_ = 0;  // asked for; 0: the scene's
  bool paused_ = false;
  std::uint32_t scale_ = 0;  // pixels of the film across one of the picture; 0: to be begun
  Film film_;
  std::uint32_t done_ = 0;  // film samples
  double rate_ = 2e5;       // pixel samples a second; a careful first guess
  double relative_error_ = 0, error_seconds_ = 0;
  Clock::time_point begun_{}, published_{}, error_known_{};
  std::uint32_t published_done_ = 0;
  double publishing_seconds_ = 0;
  std::thread thread_;
};

}  // namespace etendue::view
