#include "core/read_log.h"

#include <sys/stat.h>

#include <atomic>
#include <mutex>

namespace etendue {
namespace {

std::atomic<bool> g_listening{false};
std::mutex g_mutex;
FileStamps g_files;

}  // namespace

FileStamp stamp_of(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return {};
  return {static_cast<std::uint64_t>(info.st_dev), static_cast<std::uint64_t>(info.st_ino),
          static_cast<std::uint64_t>(info.st_size), static_cast<std::int64_t>(info.st_mtim.tv_sec),
          static_cast<std::int64_t>(info.st_mtim.tv_nsec)};
}

ReadLog::ReadLog() {
  const std::lock_guard lock(g_mutex);
  g_files.clear();
  g_listening = true;
}

ReadLog::~ReadLog() {
  g_listening = false;
}

FileStamps ReadLog::files() const {
  const std::lock_guard lock(g_mutex);
  return g_files;
}

void note_read(const std::string& path) {
  if (!g_listening) return;
  const FileStamp stamp = stamp_of(path);
  const std::lock_guard lock(g_mutex);
  g_files.try_emplace(path, stamp);
}

}  // namespace etendue
