// Errors as colours.
#pragma once

#include "image/image.h"

namespace turner::report {

// |A - B| by the largest of a pixel's channels, on a logarithmic scale of colours from 1e-4 (dark) to 1 (bright).
Image colouredError(const Image& a, const Image& b);

// The scale's colours from left to right, as a CSS gradient has them.
inline constexpr const char* kColourBar = "#440154, #3b528b, #21918c, #5ec962, #fde725";

}  // namespace turner::report
