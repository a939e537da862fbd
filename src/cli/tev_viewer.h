#pragma once
/// Shows the picture in the viewer tev during the render: docs/tev.md.

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

/// Sends pictures from a thread of its own. The only cost for the render is a copy of the picture each time the viewer
/// has received the last one. A slow viewer gets fewer pictures; if there is none, or it disappears, there is a warning
/// and later another attempt.
class TevViewer {
 public:
  struct Report {
    std::uint64_t pictures = 0;  ///< number of pictures sent completely
    bool last = false;           ///< whether the last one was sent
  };

  /// Connects in the background. `name` is what the viewer lists the picture as.
  TevViewer(ViewerAddress address, const std::string& name);
  /// Discards what has not been sent yet.
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
  bool idle_ = false;                     ///< connected, and everything has been sent
  bool finishing_ = false;                ///< what waits is the last picture
  bool ended_ = false;                    ///< the thread has ended
  Report report_;
  Clock::time_point next_ = Clock::now();  ///< no picture before that
  std::atomic<bool> stopped_{false};       ///< the owner has requested the end

  // Used by the thread only.
  ViewerConnection connection_;
  bool created_ = false;     ///< the viewer knows the picture
  bool told_ = false;        ///< whether the missing viewer was reported
  bool sends_last_ = false;  ///< is at the last picture now
  bool sent_last_ = false;
  bool cut_short_ = false;    ///< did not send all of the picture
  bool tried_again_ = false;  ///< with the last picture
  bool impatient_ = false;    ///< the viewer took too little of it
  Clock::time_point window_;  ///< since then it took `taken_` bytes
  std::size_t taken_ = 0;

  std::thread thread_;  ///< the last member, so that everything else exists when it starts
};

}  // namespace etendue::cli
