#include "cli/signals.h"

#include <csignal>
#include <cstring>

#include <unistd.h>

#include <atomic>

#include "core/errors.h"

namespace etendue::cli {
namespace {

// Handlers may only touch lock-free atomics and call what POSIX lists as async-signal-safe.
std::atomic<int> g_stop_requests{0};
std::atomic<bool> g_image_request{false};
std::atomic<bool> g_quiet{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1};
constexpr int kSignalCount = 4;
struct sigaction g_before[kSignalCount];

void say(const char* sentence) {
  if (g_quiet) return;
  // Nothing can be done about a stderr that is gone.
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, sentence, std::strlen(sentence));
}

extern "C" void on_render_signal(int signal) {
  if (signal == SIGUSR1) {
    g_image_request = true;
    return;
  }
  if (g_stop_requests.fetch_add(1) > 0) {
    say("\nAborted.\n");
    _exit(static_cast<int>(ExitCode::interrupted));
  }
  say("\nInterrupted: finishing the pass, then saving what is done; once more to abort.\n");
}

}  // namespace

SignalWatch::SignalWatch(bool quiet) {
  g_stop_requests = 0;
  g_image_request = false;
  g_quiet = quiet;
  struct sigaction action {};
  action.sa_handler = on_render_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (int i = 0; i < kSignalCount; ++i) {
    sigaction(kSignals[i], nullptr, &g_before[i]);
    const bool under_nohup = kSignals[i] == SIGHUP && g_before[i].sa_handler == SIG_IGN;
    if (!under_nohup) sigaction(kSignals[i], &action, nullptr);
  }
}

SignalWatch::~SignalWatch() {
  for (int i = 0; i < kSignalCount; ++i) sigaction(kSignals[i], &g_before[i], nullptr);
}

bool SignalWatch::stop_asked() const {
  return g_stop_requests > 0;
}
bool SignalWatch::image_asked() const {
  return g_image_request;
}
bool SignalWatch::take_image_request() {
  return g_image_request.exchange(false);
}

}  // namespace etendue::cli
