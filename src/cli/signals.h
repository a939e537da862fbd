#pragma once
/// Signals that stop a render or ask for a picture of it.

namespace etendue::cli {

/// While it lives, SIGINT, SIGTERM and SIGHUP (unless it was ignored) ask to stop, and SIGUSR1 asks for the current
/// image. A second request to stop ends the process at once with code 130. One at a time.
class SignalWatch {
 public:
  explicit SignalWatch(bool quiet);
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

  bool stop_asked() const;
  bool image_asked() const;
  /// Forgets the request for an image; returns whether there was one.
  bool take_image_request();
};

}  // namespace etendue::cli
