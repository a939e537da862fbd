#include "formats/input_file.h"

#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/printable.h"
#include "core/read_log.h"
#include "core/text.h"

namespace etendue {
namespace {

constexpr std::size_t kMostShown = 300;  // of a name that a scene may make as long as it likes

/// Why a file could not be opened.
std::string reason(const std::string& path, int error) {
  std::array<char, PATH_MAX> target{};
  const ssize_t length = error == ENOENT ? ::readlink(path.c_str(), target.data(), target.size()) : -1;
  const char* pointer =
      length < 0 ? nullptr : text::link_sentence(std::string_view(target.data(), static_cast<std::size_t>(length)));
  return pointer != nullptr ? pointer : std::strerror(error);
}

}  // namespace

InputFile::InputFile(const std::string& path) : path_(text::printable(path, kMostShown)) {
  note_read(path);
  // O_NONBLOCK lets open() return at once for a FIFO, which is then refused by its kind.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (descriptor_ < 0) {
    throw Error(ErrorKind::scene, fmt::format("{}: cannot open the file: {}", path_, reason(path, errno)));
  }
  struct stat info {};
  const bool known = ::fstat(descriptor_, &info) == 0;
  if (known && S_ISREG(info.st_mode)) {
    size_ = static_cast<std::uint64_t>(info.st_size);
    return;
  }
  ::close(descriptor_);
  const char* kind = known && S_ISDIR(info.st_mode) ? "a folder" : "not a regular file (a pipe, socket or device)";
  throw Error(ErrorKind::scene, fmt::format("{}: this is {}; give the path of a regular file", path_, kind));
}

InputFile::~InputFile() {
  ::close(descriptor_);
}

std::size_t InputFile::read(char* buffer, std::size_t capacity) {
  for (;;) {
    const ssize_t count = ::read(descriptor_, buffer, capacity);
    if (count >= 0) return static_cast<std::size_t>(count);
    if (errno != EINTR) {
      throw Error(ErrorKind::file, fmt::format("{}: cannot read the file: {}", path_, std::strerror(errno)));
    }
  }
}

void InputFile::read_at(std::uint64_t offset, char* buffer, std::size_t count) const {
  while (count > 0) {
    const ssize_t got = ::pread(descriptor_, buffer, count, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw Error(ErrorKind::file, fmt::format("{}: cannot read the file: {}", path_, std::strerror(errno)));
    if (got == 0) throw Error(ErrorKind::file, fmt::format("{}: the file became shorter while it was read", path_));
    buffer += got;
    offset += static_cast<std::uint64_t>(got);
    count -= static_cast<std::size_t>(got);
  }
}

}  // namespace etendue
