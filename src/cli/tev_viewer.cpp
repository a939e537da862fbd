#include "cli/tev_viewer.h"

#include <algorithm>
#include <utility>

#include <fmt/core.h>

#include "cli/tev_packets.h"
#include "core/log.h"
#include "core/printable.h"

namespace etendue::cli {
namespace {

constexpr std::chrono::milliseconds kBetweenPictures{500};
constexpr int kCostShare = 20;  // making pictures may take at most 1/kCostShare of the time
constexpr std::chrono::seconds kBetweenTries{2};
constexpr std::chrono::milliseconds kLookForEnd{200};
constexpr std::chrono::seconds kViewerPatience{10};
constexpr std::size_t kLeastTaken = std::size_t{1} << 20;  // in that time
constexpr std::chrono::seconds kClosingPatience{2};
constexpr std::size_t kLongestName = 200;

}  // namespace

TevViewer::TevViewer(ViewerAddress address, const std::string& name)
    : address_(std::move(address)), name_(text::printable(name, kLongestName)), thread_([this] { work(); }) {}

TevViewer::~TevViewer() {
  stopped_ = true;
  changed_.notify_all();
  thread_.join();
}

bool TevViewer::wants_picture() const {
  const std::lock_guard lock(mutex_);
  return idle_ && waiting_ == nullptr && Clock::now() >= next_;
}

void TevViewer::show(const std::function<Image()>& picture) {
  const auto start = Clock::now();
  auto made = std::make_shared<const Image>(picture());
  const auto now = Clock::now();
  const std::lock_guard lock(mutex_);
  next_ = now + std::max<Clock::duration>(kBetweenPictures, kCostShare * (now - start));
  waiting_ = std::move(made);
  changed_.notify_all();
}

TevViewer::Report TevViewer::finish(Image picture, const std::function<bool()>& stop) {
  std::unique_lock lock(mutex_);
  waiting_ = std::make_shared<const Image>(std::move(picture));
  finishing_ = true;
  changed_.notify_all();
  while (!ended_ && !stop()) changed_.wait_for(lock, kLookForEnd);
  return report_;
}

void TevViewer::work() {
  while (!stopped_) {
    const bool last = [&] {
      const std::lock_guard lock(mutex_);
      return finishing_;
    }();
    if (!connection_.is_open() && !connect(last)) {
      if (last) break;
      pause();
      continue;
    }
    serve();
    // The last picture is tried once more with a viewer that was lost on the way, and not for ever.
    if (impatient_ || (sends_last_ && (sent_last_ || std::exchange(tried_again_, true)))) break;
  }
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

// The time until the next attempt to reach the viewer.
void TevViewer::pause() {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kBetweenTries, [&] { return finishing_ || stopped_; });
}

bool TevViewer::connect(bool last) {
  const std::string error = connection_.open(address_, [&] { return !stopped_; });
  created_ = false;
  if (!error.empty() && last) tell(fmt::format("did not receive the last picture: {}", error));
  if (!error.empty() && !last)
    tell(fmt::format("does not answer: {}; the render continues, and appears as soon as tev listens there", error));
  return error.empty();
}

// Once for each time that a viewer is lost.
void TevViewer::tell(const std::string& what) {
  if (stopped_ || std::exchange(told_, true)) return;
  log::warning(fmt::format("The viewer at {} {}.", to_text(address_), what));
}

// Waits for a picture and sends it, or finds that the viewer has gone.
void TevViewer::serve() {
  std::shared_ptr<const Image> picture;
  {
    std::unique_lock lock(mutex_);
    idle_ = true;
    changed_.wait_for(lock, kLookForEnd, [&] { return waiting_ != nullptr || stopped_; });
    picture = std::exchange(waiting_, nullptr);
    idle_ = false;
    sends_last_ = finishing_ && picture != nullptr;
  }
  if (stopped_) return;
  cut_short_ = false;
  std::string error = connection_.was_closed() ? "it closed the connection" : "";
  if (picture != nullptr && error.empty()) error = send(*picture);
  if (sends_last_ && error.empty() && !connection_.finish(kClosingPatience, [&] { return !stopped_; }))
    error = "it closed the connection";
  if (!error.empty()) {
    lose(error, picture);
  } else if (picture != nullptr && !cut_short_) {
    told_ = false;
    sent_last_ = sends_last_;
    const std::lock_guard lock(mutex_);
    ++report_.pictures;
    report_.last = sends_last_;
  }
}

// The last picture interrupts an earlier one between two packets. Returns what went wrong.
std::string TevViewer::send(const Image& picture) {
  window_ = Clock::now();
  taken_ = 0;
  const auto packet = [&](const Packet& bytes) {
    return connection_.send(
        bytes, [&] { return goes_on(); }, [&](std::size_t count) { taken_ += count; });
  };
  std::string error;
  if (!created_) error = packet(tev_create(name_, picture));
  created_ = error.empty();
  const std::uint32_t rows = tev_rows(picture);
  for (std::uint32_t row = 0; error.empty() && row < picture.height; row += rows) {
    cut_short_ = last_waits();
    if (cut_short_) break;
    error = packet(tev_update(name_, picture, row, std::min(rows, picture.height - row)));
  }
  return error;
}

bool TevViewer::last_waits() const {
  const std::lock_guard lock(mutex_);
  return finishing_ && !sends_last_;
}

void TevViewer::lose(const std::string& reason, std::shared_ptr<const Image> picture) {
  connection_.close();
  if (impatient_) {
    tell("did not receive the last picture: it accepts less than 1 MiB in ten seconds");
    return;
  }
  if (!sends_last_) {
    tell(fmt::format("was lost: {}; the render continues", reason));
    return;
  }
  if (tried_again_) tell(fmt::format("did not receive the last picture: {}", reason));
  const std::lock_guard lock(mutex_);
  waiting_ = std::move(picture);
}

// A slow viewer does not matter while the render continues.
bool TevViewer::goes_on() {
  if (stopped_) return false;
  {
    const std::lock_guard lock(mutex_);
    if (!finishing_) {
      window_ = Clock::now();
      taken_ = 0;
      return true;
    }
  }
  if (Clock::now() - window_ < kViewerPatience) return true;
  impatient_ = taken_ < kLeastTaken;
  window_ = Clock::now();
  taken_ = 0;
  return !impatient_;
}

}  // namespace etendue::cli
