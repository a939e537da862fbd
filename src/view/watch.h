#pragma once
/// Detects files that have changed on disk.

#include "core/read_log.h"

namespace etendue::view {

/// Compares files whenever it is called, which works on every file system and for files that come and go.
class FileWatch {
 public:
  /// True if files differ from what they were when read, but not since the last call, so whoever writes them has
  /// probably finished. Reports each such change only once.
  bool changed(const FileStamps& read);

 private:
  FileStamps last_, told_;
};

}  // namespace etendue::view
