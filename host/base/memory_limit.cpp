// getrlimit().
#include "base/memory_limit.h"

#include <sys/resource.h>

namespace turner {

std::string memoryLimitHint() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "";
  return " (this process may have " + std::to_string(limit.rlim_cur >> 20) + " MiB of memory: ulimit -v)";
}

}  // namespace turner
