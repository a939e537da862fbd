#include "image/files.h"

#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <random>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/errors.h"
#include "core/read_log.h"

namespace etendue {
namespace {

/// During its lifetime, a write beyond RLIMIT_FSIZE fails with EFBIG in this thread instead of ending the process by
/// SIGXFSZ.
class HoldFileSizeSignal {
 public:
  HoldFileSizeSignal() {
    sigemptyset(&signal_);
    sigaddset(&signal_, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &signal_, &before_);
  }
  ~HoldFileSizeSignal() {
    // If the caller blocks the signal itself, a pending one is left alone; otherwise the one raised here is consumed
    // before it is unblocked.
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

/// fsync, except that a file system that cannot flush is not an error.
int flush(int descriptor) {
  int result;
  do {
    result = fsync(descriptor);
  } while (result != 0 && errno == EINTR);
  return result != 0 && errno != EINVAL && errno != EROFS && errno != ENOTSUP ? errno : 0;
}

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  int get() const { return number_; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_ = -1;
};

/// The folder and the name in it to which a path leads after all symbolic links; if it leads nowhere, what failed.
struct Place {
  Descriptor folder;
  std::string name;
  const char* failed = nullptr;  ///< what could not be done, with errno in `error`
  int error = 0;
};

/// The kernel setting /proc/sys/fs/`name`; 1 if it cannot be read.
int kernel_setting(const char* name) {
  char digit = '1';
  const Descriptor file(open(fmt::format("/proc/sys/fs/{}", name).c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() >= 0 && read(file.get(), &digit, 1) != 1) digit = '1';
  return digit - '0';
}

/// The kernel's decision about following a link (may_follow_link in fs/namei.c): in a sticky folder that everybody may
/// write to, only the user's own links and those of the folder's owner are followed. open() follows links by itself,
/// but here the target must be known, so the same decision is made here.
bool may_follow(int folder, int link) {
  struct stat above {
  }, itself{};
  if (fstat(folder, &above) != 0 || fstat(link, &itself) != 0) return false;
  const bool anybody = (above.st_mode & S_ISVTX) != 0 && (above.st_mode & S_IWOTH) != 0;
  return !anybody || itself.st_uid == geteuid() || itself.st_uid == above.st_uid ||
         kernel_setting("protected_symlinks") == 0;
}

Descriptor open_folder(int at, const std::string& path) {
  Descriptor folder(openat(at, path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // A folder that may be written but not listed will do, too, but cannot be flushed.
  if (folder.get() < 0 && errno == EACCES)
    folder = Descriptor(openat(at, path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  return folder;
}

Place find_place(const std::string& path) {
  // The kernel decides first, whatever its reasons; dangling links are ENOENT.
  const Descriptor target(open(path.c_str(), O_PATH | O_CLOEXEC));
  if (target.get() < 0 && errno != ENOENT) return {.failed = "cannot open it", .error = errno};
  Place place;
  std::filesystem::path rest = path;
  for (int links = 0;; ++links) {
    const std::string parent = rest.parent_path().empty() ? "." : rest.parent_path().string();
    Descriptor folder = open_folder(links == 0 ? AT_FDCWD : place.folder.get(), parent);
    if (folder.get() < 0) return {.failed = "cannot open the folder", .error = errno};
    place.folder = std::move(folder);
    place.name = rest.filename().string();
    // Each link is kept open while it is checked and read, so that nobody can replace it in between.
    const Descriptor link(openat(place.folder.get(), place.name.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
    struct stat status {};
    if (link.get() < 0 || fstat(link.get(), &status) != 0 || !S_ISLNK(status.st_mode)) return place;
    const auto refused = [](int error) { return Place{.failed = "cannot follow the symbolic link", .error = error}; };
    if (links == 40) return refused(ELOOP);
    if (!may_follow(place.folder.get(), link.get())) return refused(EACCES);
    std::array<char, PATH_MAX> next;
    const ssize_t length = readlinkat(link.get(), "", next.data(), next.size());
    if (length < 0) return refused(errno);
    rest = std::string(next.data(), static_cast<std::size_t>(length));
  }
}

}  // namespace

void AtomicFile::fail(const char* action, int error) const {
  throw Error(ErrorKind::file, fmt::format("{}: {}: {}; nothing was written there", path_, action,
                                           std::generic_category().message(error)));
}

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  const auto is_name = [](const std::string& name) { return !name.empty() && name != "." && name != ".."; };
  const auto refuse_name = [&] { throw Error(ErrorKind::file, fmt::format("\"{}\" is not the name of a file", path)); };
  if (path.find('\0') != std::string::npos || !is_name(std::filesystem::path(path).filename().string())) refuse_name();
  Place place = find_place(path);
  if (place.failed != nullptr) fail(place.failed, place.error);
  name_ = place.name;
  if (!is_name(name_)) refuse_name();
  folder_ = place.folder.release();
  try {
    create_beside(mode_of_existing());
  } catch (...) {
    close(folder_);
    throw;
  }
}

// The permissions of the existing file, which may be replaced, or -1 if there is none.
int AtomicFile::mode_of_existing() const {
  struct stat existing {};
  if (fstatat(folder_, name_.c_str(), &existing, AT_SYMLINK_NOFOLLOW) != 0) {
    if (errno != ENOENT) fail("cannot examine it", errno);
    return -1;
  }
  if (S_ISDIR(existing.st_mode)) fail("cannot replace it", EISDIR);
  if (!S_ISREG(existing.st_mode)) {
    throw Error(ErrorKind::file,
                fmt::format("{}: is a device, pipe or socket and cannot be replaced; give the name of a file", path_));
  }
  // Opened in the same way as by the shell, but not truncated, so that permissions, protected_regular and all other
  // kernel rules apply.
  const Descriptor probe(
      openat(folder_, name_.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, 0666));
  if (probe.get() < 0) fail("cannot replace it", errno);
  return existing.st_mode & 07777;
}

void AtomicFile::create_beside(int mode) {
  std::random_device random;
  // Names have at most 255 bytes; the beginning of the target's name shows the user where a leftover comes from after a
  // power cut.
  const std::string start = name_.substr(0, std::min<std::size_t>(name_.size(), 200));
  for (int attempt = 0; attempt < 100 && file_ < 0; ++attempt) {
    temporary_ = fmt::format(".{}.{:08x}.tmp", start, random());
    file_ = openat(folder_, temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file_ < 0 && errno != EEXIST) break;
  }
  if (file_ < 0) {
    const int error = errno;
    temporary_.clear();
    fail("cannot create a file next to it", error);
  }
  // Keeps the permissions of the replaced file. A file system without permissions is no reason to lose a render.
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
  // A power cut could undo the rename. EBADF means that the folder could only be opened as a path.
  if (const int error = flush(folder_); error != 0 && error != EBADF) {
    throw Error(ErrorKind::file, fmt::format("{}: is written, but the folder could not be flushed to the disk: {}",
                                             path_, std::generic_category().message(error)));
  }
}

bool is_same_place(const std::string& a, const std::string& b) {
  const Place first = find_place(a), second = find_place(b);
  if (first.failed != nullptr || second.failed != nullptr) return false;
  const auto same = [](const struct stat& x, const struct stat& y) {
    return x.st_dev == y.st_dev && x.st_ino == y.st_ino;
  };
  struct stat x {
  }, y{};
  if (fstat(first.folder.get(), &x) == 0 && fstat(second.folder.get(), &y) == 0 && same(x, y) &&
      first.name == second.name)
    return true;
  return fstatat(first.folder.get(), first.name.c_str(), &x, AT_SYMLINK_NOFOLLOW) == 0 &&
         fstatat(second.folder.get(), second.name.c_str(), &y, AT_SYMLINK_NOFOLLOW) == 0 && same(x, y);
}

void write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  AtomicFile file(path);
  file.write(bytes);
  file.commit();
}

std::vector<std::byte> read_file(const std::string& path, std::uint64_t limit) {
  const auto fail = [&](const char* action, int error) {
    throw Error(ErrorKind::file, fmt::format("{}: {}: {}", path, action, std::generic_category().message(error)));
  };
  note_read(path);
  // Non-blocking, because opening a pipe without a writer would wait for ever.
  const int descriptor = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) fail("cannot open it", errno);
  const struct Closer {
    int descriptor;
    ~Closer() { close(descriptor); }
  } closer{descriptor};
  struct stat status;
  if (fstat(descriptor, &status) != 0) fail("cannot examine it", errno);
  if (S_ISDIR(status.st_mode)) fail("cannot read it", EISDIR);
  if (!S_ISREG(status.st_mode)) {
    throw Error(ErrorKind::file, fmt::format("{}: is a device, pipe or socket; give the name of a file", path));
  }
  std::vector<std::byte> bytes(std::min(limit, static_cast<std::uint64_t>(status.st_size)));
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::read(descriptor, bytes.data() + done, std::min<std::size_t>(bytes.size() - done, 1u << 30));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("cannot read it", errno);
    if (count == 0) break;  // the file has become shorter
    done += static_cast<std::size_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace etendue
