// What both listeners of `turner watch` print alike.
#pragma once

#include <vector>

#include "watch/diagnosis/diagnosis.h"

namespace turner {

// To stderr.
void printDiagnoses(const std::vector<watch::Diagnosis>& diagnoses);

// Of stdout: what another process reads has to come at once. Throws RunError: without a reader there is nothing to
// watch for.
void flushOutput();

}  // namespace turner
