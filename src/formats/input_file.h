#pragma once
/// Opening files that a user named, with everything refused that is not a plain file.

#include <cstddef>
#include <cstdint>
#include <string>

namespace etendue {

/// A regular file open for reading. Folders, FIFOs, sockets and devices are refused before a byte is read: a FIFO would
/// block for ever and /dev/zero never ends.
class InputFile {
 public:
  /// Throws Error(scene) with the path and the reason.
  explicit InputFile(const std::string& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  /// Size in bytes when it was opened.
  std::uint64_t size() const { return size_; }
  /// Reads up to `capacity` bytes and returns how many; 0 at the end. Throws Error(file).
  std::size_t read(char* buffer, std::size_t capacity);
  /// Reads that many bytes from a place in the file, wherever read() has come to. Throws Error(file), also where the
  /// file ends before.
  void read_at(std::uint64_t offset, char* buffer, std::size_t count) const;

 private:
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace etendue
