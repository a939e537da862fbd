#pragma once
/// Small file systems for tests of full and read-only disks, for root and for plain users alike.

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <unistd.h>

#include <string>

namespace etendue {

inline bool write_proc(const char* path, const std::string& text) {
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  return close(file) == 0 && written;
}

/// Gives this process mounts of its own. A plain user becomes root of a user namespace for it, in which he stays the
/// owner of his files; the process must have one thread then. False where the kernel allows neither; errno says why.
inline bool own_mounts() {
  const uid_t user = geteuid();
  const gid_t group = getegid();
  if (user == 0) {
    if (unshare(CLONE_NEWNS) != 0) return false;
  } else {
    if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return false;
    if (!write_proc("/proc/self/setgroups", "deny") ||
        !write_proc("/proc/self/uid_map", "0 " + std::to_string(user) + " 1") ||
        !write_proc("/proc/self/gid_map", "0 " + std::to_string(group) + " 1"))
      return false;
  }
  return mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
}

/// A file system in memory that only this process and its children see. `options`: "size=64k".
inline bool mount_tmpfs(const std::string& folder, const char* options) {
  return own_mounts() && mount("etendue-test", folder.c_str(), "tmpfs", 0, options) == 0;
}

}  // namespace etendue
