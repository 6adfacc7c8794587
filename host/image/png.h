// PNG out: sRGB, 8 bits, clamped to [0, 1]. libpng appears in png.cpp only.
#pragma once

#include <string>

#include "image/image.h"

namespace turner {

// The bytes of a PNG file with the pixels of image.window. NaN becomes 0. Depends on its argument alone.
std::string encodePng(const Image& image);

}  // namespace turner
