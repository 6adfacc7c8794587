// A binary tree of boxes: with it the reference asks only for the few things that a ray may hit.
// Comes in: the box of each thing. Goes out: the numbers of the things whose boxes a ray meets, near ones first.
// Knows nothing of spheres and triangles, and nothing of the kernel's own structure, whose witness it is.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <utility>
#include <vector>

namespace turner::reference {

struct Box {
  glm::dvec3 low{std::numeric_limits<double>::infinity()};
  glm::dvec3 high{-std::numeric_limits<double>::infinity()};

  void include(const Box& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
  void include(const glm::dvec3& point) { include({point, point}); }
};

class BoxTree {
 public:
  // Each box is widened by `slack` on all sides: more than the error with which things are tested, so that the tree
  // never hides a hit.
  BoxTree(const std::vector<Box>& boxes, double slack);

  // Calls visit(i) for every box i that the ray may meet within `limit`. What visit returns is the limit from then on:
  // the nearest hit so far, or something negative to stop.
  template <class Visit>
  void traverse(const glm::dvec3& origin, const glm::dvec3& direction, double limit, Visit&& visit) const;

 private:
  // Nodes stand in depth-first order, so that the first child follows its parent.
  struct Node {
    Box box;
    uint32_t start = 0;  // leaf: the first of its items; inner node: its second child
    uint32_t count = 0;  // leaf: the number of its items; inner node: 0
  };

  // Splits by surface area only down to this level, then in halves: 32 more levels are enough for 2^32 items.
  static constexpr int kAreaLevels = 32;
  static constexpr int kMaxLevels = kAreaLevels + 33;

  void build(const std::vector<Box>& boxes, uint32_t begin, uint32_t end, int level);
  uint32_t split(const std::vector<Box>& boxes, const Box& centres, uint32_t begin, uint32_t end, int level);

  std::vector<Node> nodes;
  std::vector<uint32_t> items;
};

// Where the ray enters the box, or infinity if it misses it. Slab method of Kay and Kajiya (SIGGRAPH 1986).
inline double enterBox(const Box& box, const glm::dvec3& origin, const glm::dvec3& inverse) {
  const glm::dvec3 a = (box.low - origin) * inverse, b = (box.high - origin) * inverse;
  const glm::dvec3 entries = glm::min(a, b), exits = glm::max(a, b);
  const double entry = std::max({entries.x, entries.y, entries.z, 0.0});
  const double exit = std::min({exits.x, exits.y, exits.z});
  // Far more than these few roundings of 2^-53 and those of a hit's own distance; it costs nothing.
  constexpr double relativeSlack = 0x1p-40;
  return entry * (1 - relativeSlack) <= exit * (1 + relativeSlack) ? entry * (1 - relativeSlack)
                                                                   : std::numeric_limits<double>::infinity();
}

template <class Visit>
void BoxTree::traverse(const glm::dvec3& origin, const glm::dvec3& direction, double limit, Visit&& visit) const {
  if (nodes.empty()) return;
  // A component that is zero becomes tiny. Then the two slab distances of that axis are huge, with the right signs, and
  // never the NaN of 0 times infinity.
  glm::dvec3 inverse;
  for (int k = 0; k < 3; ++k)
    inverse[k] = 1 / (std::abs(direction[k]) < 1e-300 ? std::copysign(1e-300, direction[k]) : direction[k]);

  struct Entry {
    uint32_t node;
    double distance;
  };
  std::array<Entry, kMaxLevels> stack;
  int height = 0;
  Entry at{0, enterBox(nodes[0].box, origin, inverse)};
  while (true) {
    if (at.distance < std::numeric_limits<double>::infinity() && at.distance <= limit) {
      const Node& node = nodes[at.node];
      if (node.count == 0) {
        // Go on with the nearer child, keep the other for later.
        Entry near{at.node + 1, enterBox(nodes[at.node + 1].box, origin, inverse)};
        Entry far{node.start, enterBox(nodes[node.start].box, origin, inverse)};
        if (far.distance < near.distance) std::swap(near, far);
        if (far.distance < std::numeric_limits<double>::infinity() && far.distance <= limit) {
          assert(height < kMaxLevels);
          stack[height++] = far;
        }
        at = near;
        continue;
      }
      for (uint32_t i = node.start; i < node.start + node.count; ++i) limit = visit(items[i]);
    }
    if (height == 0) return;
    at = stack[--height];
  }
}

}  // namespace turner::reference
