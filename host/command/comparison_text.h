// Figures of a comparison as lines for people.
#pragma once

#include <string>

#include "image/compare.h"
#include "image/envelope.h"
#include "image/error_analysis.h"

namespace turner {

std::string figuresText(const Comparison& comparison, double threshold);
std::string decompositionText(const Decomposition& decomposition);
std::string envelopeText(const EnvelopeRule& rule);

}  // namespace turner
