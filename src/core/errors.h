#pragma once
/// The one exception type of the program: a sentence for the user and the exit code it ends with.

#include <stdexcept>
#include <string>

namespace etendue {

/// Process exit codes; documented in the README.
enum class ExitCode : int {
  ok = 0,
  test_failed = 1,    ///< a comparison or statistical test failed
  usage = 2,          ///< bad command line
  scene_error = 3,    ///< bad scene or mesh
  no_device = 4,      ///< no suitable Vulkan device
  device_lost = 5,    ///< device lost or out of device memory
  file_error = 6,     ///< cannot read or write a file
  bug = 70,           ///< an error in the program itself
  skipped = 77,       ///< a test that cannot run here
  interrupted = 130,  ///< stopped by a signal after saving what is done
};

/// An error the user can do something about. `what()` is one sentence that names the place, the thing, the number and
/// what would be right.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// The driver gave the device up. The same work may well succeed on a freshly opened one.
class DeviceLost : public Error {
 public:
  explicit DeviceLost(const std::string& sentence) : Error(ExitCode::device_lost, sentence) {}
};

/// The device did not finish in time. It may be at work for ever, so it was left as it is: the process must end without
/// closing it.
class DeviceHung : public Error {
 public:
  explicit DeviceHung(const std::string& sentence) : Error(ExitCode::device_lost, sentence) {}
};

}  // namespace etendue
