// Tiles cover every stride-th pixel of a crop once.
#include "gpu/tiles.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

namespace turner {
namespace {

TEST(Tiles, CoverEveryPixelOfTheCropOnce) {
  for (const int stride : {1, 3}) {
    for (const int side : {8, 16, 64}) {
      const Window crop{5, 7, 44, 30};
      std::map<std::pair<int, int>, int> visits;
      for (const gpu::Tile& tile : cutIntoTiles(crop, stride, side)) {
        EXPECT_EQ(tile.stride, gpu::uint(stride));
        EXPECT_LE(tile.width, gpu::uint(side));
        EXPECT_LE(tile.height, gpu::uint(side));
        for (int y = 0; y < int(tile.height); ++y)
          for (int x = 0; x < int(tile.width); ++x) ++visits[{int(tile.x0) + stride * x, int(tile.y0) + stride * y}];
      }
      EXPECT_EQ(visits.size(), everyStride(crop, stride).area());
      for (int y = crop.y0; y < crop.y1; y += stride)
        for (int x = crop.x0; x < crop.x1; x += stride)
          EXPECT_EQ((visits[{x, y}]), 1) << x << ',' << y << " stride " << stride << " side " << side;
    }
  }
}

TEST(Tiles, HaveSlotsForWholeBlocks) {
  const std::vector<gpu::Tile> tiles = cutIntoTiles({0, 0, 20, 9}, 1, 16);
  ASSERT_EQ(tiles.size(), 2u);
  EXPECT_EQ(tiles[0].slots, 2 * 2 * 64u);
  EXPECT_EQ(tiles[1].slots, 1 * 2 * 64u);
}

}  // namespace
}  // namespace turner
