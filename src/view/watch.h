#pragma once
/// Whether files on the disk have changed.

#include "core/read_log.h"

namespace etendue::view {

/// Looks at files whenever it is asked to, which works on every file system and for files that come and go.
class FileWatch {
 public:
  /// True when files are no longer what they were when they were read, and have stayed the same since the last call:
  /// whoever writes one has probably finished. Only once for what they are then.
  bool changed(const FileStamps& read);

 private:
  FileStamps last_, told_;
};

}  // namespace etendue::view
