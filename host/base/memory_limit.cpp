// getrlimit(), and a mapping that is given back at once.
#include "base/memory_limit.h"

#include <sys/mman.h>
#include <sys/resource.h>

#include <new>

namespace turner {

std::string memoryLimitHint() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "";
  return " (this process may have " + std::to_string(limit.rlim_cur >> 20) + " MiB of memory: ulimit -v)";
}

void requireMemory(size_t bytes) {
  if (memoryLimitHint().empty()) return;
  void* const probe = ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (probe == MAP_FAILED) throw std::bad_alloc();
  ::munmap(probe, bytes);
}

}  // namespace turner
