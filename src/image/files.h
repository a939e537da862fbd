#pragma once
/// Whole files: read at once, and written completely or not at all.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace etendue {

/// Replaces the file at a path in one step: bytes go to a new file next to it, which is flushed to disk and renamed
/// over the path by commit(). If anything fails before that, the old file is kept and the new one is removed. A
/// symbolic link at the path stays a link: the file it leads to is replaced. Links and existing files that the kernel
/// would not open for writing (fs.protected_symlinks and fs.protected_regular in sticky folders such as /tmp) are
/// refused, as they are by the shell's `>`. Every function throws Error(file) with the path and the system's reason; a
/// file size limit (RLIMIT_FSIZE) is reported like a full disk and does not end the process.
class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(std::span<const std::byte> bytes);
  void commit();

 private:
  [[noreturn]] void fail(const char* action, int error) const;
  int mode_of_existing() const;
  void create_beside(int mode);

  std::string path_;       ///< as given, for messages
  std::string name_;       ///< file name inside folder_
  std::string temporary_;  ///< name of the new file inside folder_; empty if there is none
  int folder_ = -1;
  int file_ = -1;
};

/// Whether both paths lead to the same file: the same name in the same folder after all links, or two hard links of one
/// file. False if a path leads nowhere.
bool is_same_place(const std::string& a, const std::string& b);

void write_file_atomically(const std::string& path, std::span<const std::byte> bytes);

/// The first `limit` bytes of a regular file (all of them by default). Throws Error(file).
std::vector<std::byte> read_file(const std::string& path, std::uint64_t limit = ~std::uint64_t{0});

}  // namespace etendue
