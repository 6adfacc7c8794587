// What both listeners of `turner watch` print alike.
#pragma once

#include <string>
#include <vector>

#include "watch/diagnosis/diagnosis.h"

namespace turner {

// To stderr.
void printDiagnoses(const std::vector<watch::Diagnosis>& diagnoses);

// To stdout, for people. Throws RunError if they have closed their end: without a reader there is nothing to watch for.
void tellWatcher(const std::string& text);

}  // namespace turner
