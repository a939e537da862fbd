#include "image/files.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <random>
#include <system_error>

#include <fmt/format.h>

#include "core/errors.h"

namespace etendue {
namespace {

/// While it lives, a write beyond RLIMIT_FSIZE fails with EFBIG in this thread instead of ending the process by
/// SIGXFSZ.
class HoldFileSizeSignal {
 public:
  HoldFileSizeSignal() {
    sigemptyset(&signal_);
    sigaddset(&signal_, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &signal_, &before_);
  }
  ~HoldFileSizeSignal() {
    // A caller that holds the signal itself keeps what is pending; otherwise take ours before it is let through.
    const timespec at_once{};
    if (sigismember(&before_, SIGXFSZ) == 0) {
      while (sigtimedwait(&signal_, nullptr, &at_once) == SIGXFSZ) {
      }
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  HoldFileSizeSignal(const HoldFileSizeSignal&) = delete;
  HoldFileSizeSignal& operator=(const HoldFileSizeSignal&) = delete;

 private:
  sigset_t signal_, before_;
};

/// fsync, where a file system that has nothing to flush is not an error.
int flush(int descriptor) {
  int result;
  do {
    result = fsync(descriptor);
  } while (result != 0 && errno == EINTR);
  return result != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP ? errno : 0;
}

}  // namespace

void AtomicFile::fail(const char* action, int error) const {
  throw Error(ExitCode::file_error, fmt::format("{}: {}: {}; nothing was written there", path_, action,
                                                std::generic_category().message(error)));
}

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  namespace fs = std::filesystem;
  // Renaming over a link would replace the link, not the file the user meant.
  fs::path target = fs::path(path);
  std::error_code error;
  for (int links = 0; fs::is_symlink(fs::symlink_status(target, error)); ++links) {
    if (links == 40) fail("cannot follow the symbolic link", ELOOP);
    const fs::path next = fs::read_symlink(target, error);
    if (error) fail("cannot follow the symbolic link", error.value());
    target = target.parent_path() / next;  // just `next` when that is absolute
  }
  name_ = target.filename().string();
  const std::string folder = target.parent_path().empty() ? "." : target.parent_path().string();
  if (path.empty() || path.find('\0') != std::string::npos || name_.empty() || name_ == "." || name_ == "..") {
    throw Error(ExitCode::file_error, fmt::format("\"{}\" is not the name of a file", path));
  }
  folder_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // A folder that may be written but not listed serves as well; it cannot be flushed then.
  if (folder_ < 0 && errno == EACCES) folder_ = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (folder_ < 0) fail("cannot open the folder", errno);
  try {
    int mode = -1;
    struct stat existing;
    if (fstatat(folder_, name_.c_str(), &existing, 0) == 0) {
      if (S_ISDIR(existing.st_mode)) fail("cannot replace it", EISDIR);
      if (!S_ISREG(existing.st_mode)) {
        throw Error(
            ExitCode::file_error,
            fmt::format("{}: is a device, pipe or socket and cannot be replaced; give the name of a file", path_));
      }
      if (faccessat(folder_, name_.c_str(), W_OK, AT_EACCESS) != 0) fail("cannot replace it", errno);
      mode = existing.st_mode & 07777;
    } else if (errno != ENOENT) {
      fail("cannot look at it", errno);
    }
    create_beside(mode);
  } catch (...) {
    close(folder_);
    throw;
  }
}

void AtomicFile::create_beside(int mode) {
  std::random_device random;
  // Names have at most 255 bytes; the start of the target's tells the user whose leftover it is after a power cut.
  const std::string start = name_.substr(0, std::min<std::size_t>(name_.size(), 200));
  for (int attempt = 0; attempt < 100 && file_ < 0; ++attempt) {
    temporary_ = fmt::format(".{}.{:08x}.tmp", start, random());
    file_ = openat(folder_, temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0 && errno != EEXIST) break;
  }
  if (file_ < 0) {
    const int error = errno;
    temporary_.clear();
    fail("cannot create a file beside it", error);
  }
  // Keep the permissions of what is replaced. A file system without them is no reason to lose a render.
  if (mode >= 0 && fchmod(file_, static_cast<mode_t>(mode)) != 0) return;
}

AtomicFile::~AtomicFile() {
  if (file_ >= 0) close(file_);
  if (!temporary_.empty()) unlinkat(folder_, temporary_.c_str(), 0);
  if (folder_ >= 0) close(folder_);
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  const HoldFileSizeSignal hold;
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), std::min<std::size_t>(bytes.size(), std::size_t{1} << 30));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("cannot write", written < 0 ? errno : ENOSPC);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void AtomicFile::commit() {
  if (const int error = flush(file_); error != 0) fail("cannot flush to the disk", error);
  // Network file systems may report a full disk only here.
  const int closed = close(file_);
  file_ = -1;
  if (closed != 0 && errno != EINTR) fail("cannot close", errno);
  if (renameat(folder_, temporary_.c_str(), folder_, name_.c_str()) != 0) fail("cannot move the new file there", errno);
  temporary_.clear();
  // The rename is what a power cut could undo. EBADF: the folder could only be opened as a path.
  if (const int error = flush(folder_); error != 0 && error != EBADF) {
    throw Error(ExitCode::file_error, fmt::format("{}: is written, but the folder could not be flushed to the disk: {}",
                                                  path_, std::generic_category().message(error)));
  }
}

void write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

std::vector<std::byte> read_file(const std::string& path, std::uint64_t limit) {
  const auto fail = [&](const char* action, int error) {
    throw Error(ExitCode::file_error, fmt::format("{}: {}: {}", path, action, std::generic_category().message(error)));
  };
  // Not blocking: opening a pipe without a writer would wait for ever.
  const int descriptor = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) fail("cannot open it", errno);
  const struct Closer {
    int descriptor;
    ~Closer() { close(descriptor); }
  } closer{descriptor};
  struct stat status;
  if (fstat(descriptor, &status) != 0) fail("cannot look at it", errno);
  if (S_ISDIR(status.st_mode)) fail("cannot read it", EISDIR);
  if (!S_ISREG(status.st_mode)) {
    throw Error(ExitCode::file_error, fmt::format("{}: is a device, pipe or socket; give the name of a file", path));
  }
  std::vector<std::byte> bytes(std::min(limit, static_cast<std::uint64_t>(status.st_size)));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::read(descriptor, bytes.data() + done, std::min<std::size_t>(bytes.size() - done, 1u << 30));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("cannot read it", errno);
    if (count == 0) break;  // became shorter meanwhile
    done += static_cast<std::size_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace etendue
