#include "cli/signals.h"

#include <poll.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <iterator>

#include "cli/ending.h"

namespace etendue::cli {
namespace {

// Handlers may only touch lock-free atomics and call what POSIX lists as async-signal-safe.
std::atomic<bool> g_stop_request{false};
std::atomic<bool> g_image_request{false};
std::atomic<bool> g_saving{false};
std::atomic<bool> g_quiet{false};
/// When the first SIGINT or SIGTERM came, ns of the monotonic clock; 0: not yet.
std::atomic<std::int64_t> g_first_time{0};
static_assert(std::atomic<std::int64_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

constexpr std::int64_t kOneRequest = 300'000'000;  // ns: signals that belong together

// All signals that end a program without a core dump and can be caught, except SIGPIPE and SIGXFSZ, which writes report
// themselves, and those of faults in the program. SIGXCPU is sent by the kernel every second beyond `ulimit -S -t`.
constexpr int kSignals[] = {SIGINT,  SIGTERM,   SIGHUP,  SIGUSR1, SIGUSR2, SIGXCPU,
                            SIGALRM, SIGVTALRM, SIGPROF, SIGPWR,  SIGPOLL};
constexpr int kSignalCount = static_cast<int>(std::size(kSignals));
struct sigaction g_before[kSignalCount];

void say(const char* sentence) {
  if (g_quiet) return;
  // Nothing can be done if stderr is gone, and a pipe that nobody reads must not block the process.
  pollfd stream{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (poll(&stream, 1, 0) != 1) return;
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, sentence, std::strlen(sentence));
}

bool is_impatient(int signal) {
  if (signal != SIGINT && signal != SIGTERM) return false;  // shells, timers and the kernel repeat the others
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  const std::int64_t now = std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
  std::int64_t first = 0;
  if (g_first_time.compare_exchange_strong(first, now)) return false;
  return now - first > kOneRequest;
}

extern "C" void on_render_signal(int signal) {
  const int saved_errno = errno;
  if (signal == SIGUSR1) {
    g_image_request = true;
    return;
  }
  if (!g_saving) {
    say("\nnote: Interrupted before anything was rendered; nothing was written.\n");
    _exit(exit_code(ErrorKind::interrupted));
  }
  if (is_impatient(signal)) {
    say("\nnote: Aborted.\n");
    _exit(exit_code(ErrorKind::interrupted));
  }
  if (!g_stop_request.exchange(true))
    say("\nnote: Interrupted: finishing the pass, then saving what is done; once more to abort.\n");
  errno = saved_errno;
}

}  // namespace

SignalWatch::SignalWatch(bool quiet) {
  g_stop_request = false;
  g_image_request = false;
  g_saving = false;
  g_first_time = 0;
  g_quiet = quiet;
  struct sigaction action {};
  action.sa_handler = on_render_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (int i = 0; i < kSignalCount; ++i) {
    sigaction(kSignals[i], nullptr, &g_before[i]);
    // Ignored by nohup. SIGINT is ignored in background jobs of scripts, too, but is honoured anyway.
    const bool deliberate = kSignals[i] != SIGINT && kSignals[i] != SIGTERM && kSignals[i] != SIGUSR1;
    if (deliberate && g_before[i].sa_handler == SIG_IGN) continue;
    sigaction(kSignals[i], &action, nullptr);
  }
}

SignalWatch::~SignalWatch() {
  for (int i = 0; i < kSignalCount; ++i) sigaction(kSignals[i], &g_before[i], nullptr);
}

void SignalWatch::saving_starts() {
  g_saving = true;
}
bool SignalWatch::stop_asked() const {
  return g_stop_request;
}
bool SignalWatch::image_asked() const {
  return g_image_request;
}
bool SignalWatch::take_image_request() {
  return g_image_request.exchange(false);
}

}  // namespace etendue::cli
