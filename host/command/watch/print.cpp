// stdout and stderr.
#include "command/watch/print.h"

#include <cerrno>
#include <cstring>
#include <string>

#include "base/errors.h"
#include "base/tell.h"

namespace turner {
using namespace watch;

void printDiagnoses(const std::vector<Diagnosis>& diagnoses) {
  for (const Diagnosis& diagnosis : diagnoses) tellOnStderr("{}\n", gccText(diagnosis));
}

void tellWatcher(const std::string& text) {
  if (tellText(text) == EPIPE) throw RunError(std::string("<stdout>: error: cannot write: ") + std::strerror(EPIPE));
}

}  // namespace turner
