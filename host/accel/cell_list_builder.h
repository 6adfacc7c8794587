// The lists of a block of cells on a face: which primitives or nodes rays through each cell can hit. Knows nothing of
// how lists are stored for the kernel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "layout.h"
#include "primitives/cube_face.h"

namespace turner {

struct LightBufferTree;

struct CellListEntry {
  gpu::uint reference;
  float distance;
};

struct CellList {
  gpu::uint first = 0, end = 0;  // in the block's entries
};

// A square of coarse cells. Those that were divided less than others have the same list several times.
struct CellBlock {
  std::vector<uint8_t> levels;  // of each coarse cell, row by row: it has 2^levels fine cells on a side
  std::vector<CellList> lists;  // of the fine cells of each coarse cell, row by row
  std::vector<CellListEntry> entries;
  bool visitsNodes = false;
};

// The most that a block may use.
struct CellBlockBounds {
  size_t fineCells, entries;
};

// Fills the `side` x `side` coarse cells of a square of the face; about so many rays come through each.
CellBlock buildCellBlock(const LightBufferTree& tree, const CubeFace& face, const FaceRect& rect, int side,
                         double raysInCell, const CellBlockBounds& bounds);

}  // namespace turner
