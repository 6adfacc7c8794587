// A limit of memory (ulimit -v) looks like other faults: a driver that cannot be loaded is a driver that is not there.
#pragma once

#include <string>

namespace turner {

// What messages about such faults end with, " (this process may have 500 MiB of memory: ulimit -v)"; empty where there
// is no limit.
std::string memoryLimitHint();

}  // namespace turner
