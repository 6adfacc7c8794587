// A crop of the picture cut into tiles. No Vulkan here.
#pragma once

#include <vector>

#include "image/image.h"
#include "layout.h"

namespace turner {

// Every stride-th pixel of a crop across and down, as a crop of the picture that these pixels make by themselves.
Window everyStride(const Window& crop, int stride);

// The tiles of every stride-th pixel of a crop, at most side x side of these pixels each; left to right, top to bottom.
// Each has slots for whole blocks of 8x8 pixels.
std::vector<gpu::Tile> cutIntoTiles(const Window& crop, int stride, int side);

}  // namespace turner
