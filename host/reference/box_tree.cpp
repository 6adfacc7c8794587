// Binned surface-area splits, then halves; doubles throughout.
#include "reference/box_tree.h"

#include <numeric>

namespace turner::reference {
namespace {

constexpr uint32_t kLeafItems = 4;
constexpr int kBins = 16;

glm::dvec3 centreOf(const Box& box) {
  return 0.5 * box.low + 0.5 * box.high;
}

double halfAreaOf(const Box& box) {
  const glm::dvec3 size = box.high - box.low;
  return size.x * size.y + size.y * size.z + size.z * size.x;
}

// A plane between two bins, and what it costs: the chance that a ray meets a side times the items on it.
struct BinSplit {
  double cost = std::numeric_limits<double>::infinity();
  int axis = 0;
  int bin = 0;  // the first bin of the second side
};

// Which of the axis' equal bins a centre falls in.
int binOf(double centre, double low, double extent) {
  return std::min(kBins - 1, int(kBins * ((centre - low) / extent)));
}

}  // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes, double slack) {
  items.resize(boxes.size());
  std::iota(items.begin(), items.end(), 0u);
  if (boxes.empty()) return;
  nodes.reserve(boxes.size());
  std::vector<Box> widened(boxes);
  for (Box& box : widened) {
    box.low -= slack;
    box.high += slack;
  }
  build(widened, 0, uint32_t(items.size()), 0);
}

void BoxTree::build(const std::vector<Box>& boxes, uint32_t begin, uint32_t end, int level) {
  const size_t index = nodes.size();
  nodes.emplace_back();

  Box box, centres;
  for (uint32_t i = begin; i < end; ++i) {
    box.include(boxes[items[i]]);
    centres.include(centreOf(boxes[items[i]]));
  }
  nodes[index].box = box;
  if (end - begin <= kLeafItems) {
    nodes[index].start = begin;
    nodes[index].count = end - begin;
    return;
  }
  const uint32_t middle = split(boxes, centres, begin, end, level);
  build(boxes, begin, middle, level + 1);
  nodes[index].start = uint32_t(nodes.size());
  build(boxes, middle, end, level + 1);
}

// Reorders items [begin, end) and says where the second half starts; both halves have items.
uint32_t BoxTree::split(const std::vector<Box>& boxes, const Box& centres, uint32_t begin, uint32_t end, int level) {
  const glm::dvec3 extent = centres.high - centres.low;

  // Find the cheapest plane between bins: Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007).
  BinSplit best;
  for (int axis = 0; axis < 3 && level < kAreaLevels; ++axis) {
    if (!(extent[axis] > 0)) continue;
    std::array<Box, kBins> binBox;
    std::array<uint32_t, kBins> binCount{};
    for (uint32_t i = begin; i < end; ++i) {
      const Box& box = boxes[items[i]];
      const int bin = binOf(centreOf(box)[axis], centres.low[axis], extent[axis]);
      binBox[bin].include(box);
      ++binCount[bin];
    }
    // Sweep from the right, keeping what lies right of each plane, then from the left.
    std::array<double, kBins> rightCost{};
    Box right;
    uint32_t rightCount = 0;
    for (int bin = kBins - 1; bin > 0; --bin) {
      right.include(binBox[bin]);
      rightCount += binCount[bin];
      rightCost[bin] = rightCount == 0 ? 0 : halfAreaOf(right) * rightCount;
    }
    Box left;
    uint32_t leftCount = 0;
    for (int bin = 1; bin < kBins; ++bin) {
      left.include(binBox[bin - 1]);
      leftCount += binCount[bin - 1];
      if (leftCount == 0 || leftCount == end - begin) continue;
      const double cost = halfAreaOf(left) * leftCount + rightCost[bin];
      if (cost < best.cost) best = {cost, axis, bin};
    }
  }
  if (best.cost < std::numeric_limits<double>::infinity()) {
    const auto middle = std::partition(items.begin() + begin, items.begin() + end, [&](uint32_t item) {
      return binOf(centreOf(boxes[item])[best.axis], centres.low[best.axis], extent[best.axis]) < best.bin;
    });
    return uint32_t(middle - items.begin());
  }

  // Too deep, or all centres equal: two halves of the same number.
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(items.begin() + begin, items.begin() + middle, items.begin() + end,
                   [&](uint32_t a, uint32_t b) { return centreOf(boxes[a])[axis] < centreOf(boxes[b])[axis]; });
  return middle;
}

}  // namespace turner::reference
