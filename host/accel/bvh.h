// A binary tree of boxes over boxes. Sees boxes only, never what is in them. Embree appears in bvh.cpp only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bounds.h"

namespace turner {

// A child is another node or a leaf: a run of `order`.
struct BvhChild {
  Box box;
  uint32_t first = 0;  // index of the node, or of the leaf's first entry in Bvh::order
  uint32_t count = 0;  // entries of the leaf; 0: a node
};

struct Bvh {
  struct Node {
    BvhChild children[2];
  };
  BvhChild root;                // count 0 and no nodes: the tree is empty
  std::vector<Node> nodes;      // depth first: the first child of a node stands next to it
  std::vector<uint32_t> order;  // indices of the boxes, leaf by leaf
  int depth = 0;                // nodes on the longest path
};

struct BvhLimits {
  uint32_t maxLeafSize = 4;
  int maxDepth = 48;
};

// Boxes come in kinds, one behind the other: the first box of each kind but the first, ascending. A leaf holds boxes of
// one kind only.
using KindStarts = std::vector<size_t>;

// Builds by Embree's binned surface area heuristic; where Embree gives up, or exceeds the depth, by object medians.
// Entries of a leaf are sorted. Throws RunError if Embree cannot start or memory runs out.
Bvh buildBvh(std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits = {});

// The fallback by itself: halves along the longest axis of the centroids, so that equal boxes are no trouble and the
// depth is the logarithm of their number.
Bvh buildMedianBvh(std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits = {});

}  // namespace turner
