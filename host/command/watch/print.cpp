// stdout and stderr.
#include "command/watch/print.h"

#include <fmt/format.h>

#include <cstdio>

#include "base/errors.h"

namespace turner {
using namespace watch;

void printDiagnoses(const std::vector<Diagnosis>& diagnoses) {
  for (const Diagnosis& diagnosis : diagnoses) fmt::print(stderr, "{}\n", gccText(diagnosis));
  std::fflush(stderr);
}

void flushOutput() {
  if (std::fflush(stdout) != 0) throw RunError("cannot write to standard output");
}

}  // namespace turner
