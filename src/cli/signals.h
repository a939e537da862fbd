#pragma once
/// Signals that stop a render or ask for a picture of it.

namespace etendue::cli {

/// While it lives, SIGINT, SIGTERM and SIGHUP (unless it was ignored) ask to stop, and SIGUSR1 asks for the current
/// image. Until saving_starts(), when there is nothing to save, a request to stop ends the process at once with code
/// 130. After it, so does a second SIGINT or SIGTERM, the impatient one. SIGHUP is never that one, and neither is a
/// signal within 0.3 s of the first: `timeout` sends two, to its child and to its group. One at a time.
class SignalWatch {
 public:
  explicit SignalWatch(bool quiet);
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  /// From here on the one who asks `stop_asked` stops and saves.
  void saving_starts();
  bool stop_asked() const;
  bool image_asked() const;
  /// Forgets the request for an image; returns whether there was one.
  bool take_image_request();
};

}  // namespace etendue::cli
