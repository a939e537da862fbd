#pragma once
/// Signals that stop a render or ask for a picture of it.

namespace etendue::cli {

/// During its lifetime, SIGINT, SIGTERM and SIGHUP (unless it was ignored) request a stop, and SIGUSR1 requests the
/// current image. Until saving_starts(), while there is nothing to save, a request to stop ends the process at once
/// with code 130. After that, a second SIGINT or SIGTERM does so. SIGHUP never counts as the second one, nor does a
/// signal within 0.3 s of the first, because `timeout` sends two, to its child and to its group. Only one may exist at
/// a time.
class SignalWatch {
 public:
  explicit SignalWatch(bool quiet);
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  /// From here on, the caller of `stop_asked` stops and saves.
  void saving_starts();
  bool stop_asked() const;
  bool image_asked() const;
  /// Forgets the request for an image; returns whether there was one.
  bool take_image_request();
};

}  // namespace etendue::cli
