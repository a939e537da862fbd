#include "core/page_memory.h"

#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace etendue {

void* allocate_pages(std::size_t bytes) {
  constexpr std::size_t kHugePage = std::size_t{2} << 20;
  const bool large = bytes >= 2 * kHugePage;
  const std::size_t step = large ? kHugePage : kPageBytes;
  void* const pages = std::aligned_alloc(step, (bytes + step - 1) / step * step);
  if (pages == nullptr) throw std::bad_alloc();
#ifdef __linux__
  if (large) madvise(pages, bytes / kHugePage * kHugePage, MADV_HUGEPAGE);  // where it is refused nothing changes
#endif
  return pages;
}

void free_pages(void* pages) noexcept {
  std::free(pages);
}

}  // namespace etendue
