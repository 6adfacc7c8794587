// A limit of memory (ulimit -v) looks like other faults: a driver that cannot be loaded is a driver that is not there.
#pragma once

#include <cstddef>
#include <string>

namespace turner {

// What messages about such faults end with, " (this process may have 500 MiB of memory: ulimit -v)"; empty where there
// is no limit.
std::string memoryLimitHint();

// Where there is a limit and less than this is left of it, throws std::bad_alloc.
void requireMemory(size_t bytes);

}  // namespace turner
