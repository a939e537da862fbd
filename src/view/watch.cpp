#include "view/watch.h"

namespace etendue::view {

bool FileWatch::changed(const FileStamps& read) {
  FileStamps now;
  for (const auto& [path, stamp] : read) now[path] = stamp_of(path);
  const bool rests = now == last_;
  last_ = now;
  if (now == read || now == told_ || !rests) return false;
  told_ = now;
  return true;
}

}  // namespace etendue::view
