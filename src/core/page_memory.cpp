#include "core/page_memory.h"

#include <cstdint>
#include <cstdlib>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace etendue {

namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

}  // namespace

void advise_huge_pages([[maybe_unused]] void* start, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  if (bytes < kLeastHugeBytes) return;
  const std::uintptr_t skipped = -reinterpret_cast<std::uintptr_t>(start) % kHugePage;
  madvise(static_cast<char*>(start) + skipped, (bytes - skipped) / kHugePage * kHugePage, MADV_HUGEPAGE);
#endif
}

void* allocate_pages(std::size_t bytes) {
  const std::size_t step = bytes < kLeastHugeBytes ? kPageBytes : kHugePage;
  void* const pages = std::aligned_alloc(step, (bytes + step - 1) / step * step);
  if (pages == nullptr) throw std::bad_alloc();
  advise_huge_pages(pages, bytes);
  return pages;
}

void free_pages(void* pages) noexcept {
  std::free(pages);
}

}  // namespace etendue
