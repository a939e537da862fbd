#pragma once
/// Records which files are read and their state at that time, so that changes can be detected.

#include <cstdint>
#include <map>
#include <string>

namespace etendue {

/// Facts about a file that change when it is modified; all zero if there is no such file.
struct FileStamp {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t seconds = 0, nanoseconds = 0;  ///< time of the last change
  bool operator==(const FileStamp&) const = default;
};
FileStamp stamp_of(const std::string& path);

/// Stamps by path.
using FileStamps = std::map<std::string, FileStamp>;

/// Records all files that readers open, or try to open, in any thread during its lifetime. Only one may exist at a
/// time.
class ReadLog {
 public:
  ReadLog();
  ~ReadLog();
  ReadLog(const ReadLog&) = delete;
  ReadLog& operator=(const ReadLog&) = delete;

  /// The files as they were before they were first opened.
  FileStamps files() const;
};

/// To be called before opening a file for reading.
void note_read(const std::string& path);

}  // namespace etendue
