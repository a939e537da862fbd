#pragma once
/// The one exception type of the project: a sentence for the user, and a kind.

#include <stdexcept>
#include <string>

namespace etendue {

/// What went wrong. Programs use it to decide what to do next; etendue derives its exit code from it.
enum class ErrorKind {
  usage,        ///< a wrong option or argument
  scene,        ///< bad scene or mesh
  device,       ///< no suitable Vulkan device
  lost,         ///< device lost or hanging, or out of memory
  file,         ///< a file cannot be read or written
  comparison,   ///< results differ from the expected ones
  interrupted,  ///< stopped at the caller's request
  bug,          ///< an error in the project itself
};

/// An error that the user can do something about. `what()` is one sentence that names the place, the thing, the number
/// and what would be right.
class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& sentence) : std::runtime_error(sentence), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// The driver gave up on the device. The same work may succeed on a reopened one.
class DeviceLost : public Error {
 public:
  explicit DeviceLost(const std::string& sentence) : Error(ErrorKind::lost, sentence) {}
};

/// The device did not finish in time. It may never finish, so it was left as it is: the process must end without
/// closing it.
class DeviceHung : public Error {
 public:
  explicit DeviceHung(const std::string& sentence) : Error(ErrorKind::lost, sentence) {}
};

}  // namespace etendue
