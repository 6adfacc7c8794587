// In: memory that has been taken but not touched. Out: the same, its pages mapped by madvise.
#include "base/reserve.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

namespace turner {

void prefault(void* begin, size_t bytes) {
  constexpr size_t kWorthACall = 1 << 20;
  if (bytes < kWorthACall) return;
  const auto page = uintptr_t(sysconf(_SC_PAGESIZE));
  const uintptr_t first = (uintptr_t(begin) + page - 1) / page * page, last = (uintptr_t(begin) + bytes) / page * page;
  void* const pages = reinterpret_cast<void*>(first);
  // Both are mere wishes. Kernels without large pages, or before 5.14, refuse; and where memory is short, whoever
  // writes to the pages will see.
  (void)madvise(pages, last - first, MADV_HUGEPAGE);
  (void)madvise(pages, last - first, MADV_POPULATE_WRITE);
}

}  // namespace turner
