// Word4 by row; tiles at the right and the bottom are as small as what is left.
#include "gpu/tiles.h"

#include <algorithm>

namespace turner {

using gpu::uint;

Window everyStride(const Window& crop, int stride) {
  return {0, 0, (crop.width() + stride - 1) / stride, (crop.height() + stride - 1) / stride};
}

std::vector<gpu::Tile> cutIntoTiles(const Window& crop, int stride, int side) {
  const Window grid = everyStride(crop, stride);
  std::vector<gpu::Tile> tiles;
  for (int y = 0; y < grid.y1; y += side) {
    for (int x = 0; x < grid.x1; x += side) {
      gpu::Tile tile{};
      tile.x0 = uint(crop.x0 + stride * x);
      tile.y0 = uint(crop.y0 + stride * y);
      tile.stride = uint(stride);
      tile.width = uint(std::min(side, grid.x1 - x));
      tile.height = uint(std::min(side, grid.y1 - y));
      tile.slots = ((tile.width + 7) / 8) * ((tile.height + 7) / 8) * 64;
      tiles.push_back(tile);
    }
  }
  return tiles;
}

}  // namespace turner
