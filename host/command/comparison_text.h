// Figures of a comparison as lines for people.
#pragma once

#include "image/compare.h"
#include "image/envelope.h"
#include "image/error_analysis.h"

namespace turner {

// To standard output.
void printFigures(const Comparison& comparison, double threshold);
void printDecomposition(const Decomposition& decomposition);
void printEnvelope(const EnvelopeRule& rule);

}  // namespace turner
