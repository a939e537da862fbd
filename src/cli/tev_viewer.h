#pragma once
/// A picture in the viewer tev while it renders: docs/tev.md.

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "cli/viewer_connection.h"
#include "image/image.h"

namespace etendue::cli {

/// Sends pictures from a thread of its own. The render pays for a copy of the picture when the viewer has taken the
/// last one, and for nothing else: a viewer that is slow gets fewer pictures, one that is not there or goes away costs
/// a warning and is looked for again.
class TevViewer {
 public:
  struct Report {
    std::uint64_t pictures = 0;  ///< sent whole
    bool last = false;           ///< the last one was
  };

  /// Connects in the background. `name` is what the viewer lists the picture as.
  TevViewer(ViewerAddress address, const std::string& name);
  /// Gives up what is not sent yet.
  ~TevViewer();
  TevViewer(const TevViewer&) = delete;
  TevViewer& operator=(const TevViewer&) = delete;

  const ViewerAddress& address() const { return address_; }
  /// Whether it is time for a picture, and the viewer waits for one.
  bool wants_picture() const;
  /// Makes a picture and sends it; the longer making it takes, the longer it is until the next one is wanted.
  void show(const std::function<Image()>& picture);
  /// Sends the last picture and waits until the viewer has it, is gone, takes less than 1 MiB in ten seconds, or `stop`
  /// says so. Nothing may be called afterwards.
  Report finish(Image picture, const std::function<bool()>& stop);

 private:
  using Clock = std::chrono::steady_clock;

  void work();
  void pause();
  bool connect(bool last);
  void tell(const std::string& what);
  void serve();
  std::string send(const Image& picture);
  bool last_waits() const;
  void lose(const std::string& reason, std::shared_ptr<const Image> picture);
  bool goes_on();

  const ViewerAddress address_;
  const std::string name_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const Image> waiting_;  ///< the picture to be sent next
  bool idle_ = false;                     ///< connected, and everything is sent
  bool finishing_ = false;                ///< what waits is the last picture
  bool ended_ = false;                    ///< nothing more is going to happen
  Report report_;
  Clock::time_point next_ = Clock::now();  ///< no picture before that
  std::atomic<bool> stopped_{false};       ///< the owner wants no more

  // Of the thread alone.
  ViewerConnection connection_;
  bool created_ = false;     ///< the viewer knows the picture
  bool told_ = false;        ///< that there is no viewer
  bool sends_last_ = false;  ///< is at the last picture now
  bool sent_last_ = false;
  bool cut_short_ = false;    ///< did not send all of the picture
  bool tried_again_ = false;  ///< with the last picture
  bool impatient_ = false;    ///< the viewer took too little of it
  Clock::time_point window_;  ///< since then it took `taken_` bytes
  std::size_t taken_ = 0;

  std::thread thread_;  ///< begins when all else is there
};

}  // namespace etendue::cli
