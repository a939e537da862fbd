#include "vulkan/cache_files.h"

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include <fmt/core.h>

namespace etendue::vulkan {

std::filesystem::path cache_folder() {
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg != nullptr && *xdg == '/')
    return std::filesystem::path(xdg) / "etendue";
  if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/')
    return std::filesystem::path(home) / ".cache" / "etendue";
  return {};
}

std::string read_cached(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_cached(const std::filesystem::path& path, std::span<const char> bytes) {
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  // A name of its own for each, because two devices lost at the same time are closed by two threads.
  static std::atomic<unsigned> number{0};
  const std::string beside = path.string() + fmt::format(".{}.{}", ::getpid(), number++);
  // Flushed, because a disk may turn out to be full only then.
  if (std::ofstream(beside, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush())
    std::filesystem::rename(beside, path, ignored);
  std::filesystem::remove(beside, ignored);
}

}  // namespace etendue::vulkan
