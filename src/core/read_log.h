#pragma once
/// Which files are read, and how they were when they were: for those who want to know when one of them changes.

#include <cstdint>
#include <map>
#include <string>

namespace etendue {

/// What a file looks like from outside; all zero where there is none.
struct FileStamp {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t seconds = 0, nanoseconds = 0;  ///< of the last change
  bool operator==(const FileStamp&) const = default;
};
FileStamp stamp_of(const std::string& path);

/// By path.
using FileStamps = std::map<std::string, FileStamp>;

/// While it lives, all files that readers open, or try to, in any thread. One at a time.
class ReadLog {
 public:
  ReadLog();
  ~ReadLog();
  ReadLog(const ReadLog&) = delete;
  ReadLog& operator=(const ReadLog&) = delete;

  /// As they were before they were opened first.
  FileStamps files() const;
};

/// Called by whoever opens a file to read it, before it does.
void note_read(const std::string& path);

}  // namespace etendue
