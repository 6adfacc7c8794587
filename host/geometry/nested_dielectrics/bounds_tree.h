// A tree over bounds: what meets a box, and the smallest thing that holds one.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "geometry/nested_dielectrics.h"
#include "geometry/nested_dielectrics/bounds.h"

namespace turner::nested_dielectrics {

// A tree over boxes, halved at the median of the longest side.
class BoundsTree {
 public:
  struct Item {
    Bounds box;
    uint32_t owner, index;
    double volume = 0;
  };

  explicit BoundsTree(std::vector<Item> items) : items_(std::move(items)) {
    if (!items_.empty()) build(0, uint32_t(items_.size()));
  }

  // Visits the items whose boxes meet this one and whose owner is another (kNoMedium: whoever), until `visit` returns
  // true.
  template <class Visit>
  bool findMeeting(const Bounds& box, uint32_t owner, Visit&& visit) const {
    return !nodes_.empty() && find(0, box, owner, visit);
  }

  // Of the items that `accept` and whose boxes hold this one, that with the least volume from `least` on, or nothing.
  template <class Accept>
  const Item* smallestHolding(const Bounds& box, double least, Accept&& accept) const {
    const Item* smallest = nullptr;
    if (!nodes_.empty()) findSmallest(0, box, least, accept, smallest);
    return smallest;
  }

 private:
  static constexpr uint32_t kSeveral = kNoMedium - 1;
  struct Node {
    Bounds box;
    uint32_t first, count;
    uint32_t second = 0;        // its second child; its first one stands next to it; 0: a leaf
    uint32_t owner = kSeveral;  // of all its items
    double leastVolume = std::numeric_limits<double>::infinity(), mostVolume = 0;
  };

  uint32_t build(uint32_t first, uint32_t count) {
    const uint32_t index = uint32_t(nodes_.size());
    Node node{.box = {}, .first = first, .count = count, .owner = items_[first].owner};
    Bounds centers;
    for (uint32_t i = first; i < first + count; ++i) {
      node.box.include(items_[i].box);
      const dvec3 center = 0.5 * (items_[i].box.lo + items_[i].box.hi);
      centers.include({center, center});
      if (items_[i].owner != node.owner) node.owner = kSeveral;
      node.leastVolume = std::min(node.leastVolume, items_[i].volume);
      node.mostVolume = std::max(node.mostVolume, items_[i].volume);
    }
    nodes_.push_back(node);
    if (count <= 4) return index;
    const dvec3 size = centers.hi - centers.lo;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const uint32_t half = count / 2;
    std::nth_element(items_.begin() + first, items_.begin() + first + half, items_.begin() + first + count,
                     [&](const Item& a, const Item& b) {
                       // What lies in one another comes apart by its size.
                       const double atA = a.box.lo[axis] + a.box.hi[axis], atB = b.box.lo[axis] + b.box.hi[axis];
                       return atA != atB ? atA < atB : a.volume < b.volume;
                     });
    build(first, half);
    const uint32_t second = build(first + half, count - half);
    nodes_[index].second = second;
    return index;
  }

  template <class Visit>
  bool find(uint32_t index, const Bounds& box, uint32_t owner, Visit&& visit) const {
    const Node& node = nodes_[index];
    if (node.owner == owner || !meet(node.box, box)) return false;
    if (node.second != 0) return find(index + 1, box, owner, visit) || find(node.second, box, owner, visit);
    for (uint32_t i = node.first; i < node.first + node.count; ++i)
      if (items_[i].owner != owner && meet(items_[i].box, box) && visit(items_[i])) return true;
    return false;
  }

  template <class Accept>
  void findSmallest(uint32_t index, const Bounds& box, double least, Accept&& accept, const Item*& smallest) const {
    const Node& node = nodes_[index];
    if (node.mostVolume < least || (smallest && node.leastVolume >= smallest->volume) || !holds(node.box, box)) return;
    if (node.second != 0) {
      findSmallest(index + 1, box, least, accept, smallest);
      findSmallest(node.second, box, least, accept, smallest);
      return;
    }
    for (uint32_t i = node.first; i < node.first + node.count; ++i)
      if (items_[i].volume >= least && (!smallest || items_[i].volume < smallest->volume) &&
          holds(items_[i].box, box) && accept(items_[i]))
        smallest = &items_[i];
  }

  std::vector<Item> items_;
  std::vector<Node> nodes_;
};

}  // namespace turner::nested_dielectrics
