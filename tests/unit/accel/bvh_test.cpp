#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <random>
#include <vector>

#include "accel/bvh.h"

namespace turner {
namespace {

bool contains(const Box& outer, const Box& inner) {
  return glm::min(outer.lo, inner.lo) == outer.lo && glm::max(outer.hi, inner.hi) == outer.hi;
}

// Walks the whole tree: every box once, in its leaf's and all its ancestors' boxes, leaves small and of one kind.
struct Census {
  std::vector<int> seen;
  int depth = 0;

  void visit(const Bvh& bvh, std::span<const Box> boxes, const KindStarts& kinds, const BvhChild& child, int level,
             uint32_t maxLeafSize) {
    if (child.count == 0) {
      depth = std::max(depth, level);
      const Bvh::Node& node = bvh.nodes.at(child.first);
      for (const BvhChild& below : node.children) {
        EXPECT_TRUE(contains(child.box, below.box));
        if (below.count == 0) {
          EXPECT_GT(below.first, child.first) << "not depth first";
        }
        visit(bvh, boxes, kinds, below, level + 1, maxLeafSize);
      }
      return;
    }
    EXPECT_LE(child.count, maxLeafSize);
    for (uint32_t i = child.first; i < child.first + child.count; ++i) {
      const uint32_t entry = bvh.order.at(i);
      ++seen.at(entry);
      EXPECT_TRUE(contains(child.box, boxes[entry]));
      for (const size_t start : kinds)
        EXPECT_EQ(entry < start, bvh.order[child.first] < start) << "a leaf of two kinds";
      if (i > child.first) {
        EXPECT_LT(bvh.order[i - 1], entry);
      }
    }
  }
};

void expectWhole(const Bvh& bvh, std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits = {}) {
  Census census;
  census.seen.assign(boxes.size(), 0);
  census.visit(bvh, boxes, kinds, bvh.root, 1, limits.maxLeafSize);
  EXPECT_EQ(bvh.order.size(), boxes.size());
  EXPECT_TRUE(std::all_of(census.seen.begin(), census.seen.end(), [](int n) { return n == 1; }));
  EXPECT_EQ(bvh.depth, census.depth);
  EXPECT_LE(bvh.depth, limits.maxDepth);
}

std::vector<Box> randomBoxes(size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(-10, 10), size(0, 0.3f);
  std::vector<Box> boxes(count);
  for (Box& box : boxes) {
    box.lo = {place(random), place(random), place(random)};
    box.hi = box.lo + glm::vec3(size(random), size(random), size(random));
  }
  return boxes;
}

TEST(Bvh, HoldsEveryBoxOnce) {
  for (const size_t count : {1, 2, 3, 7, 8, 9, 100, 5000}) {
    SCOPED_TRACE(count);
    const std::vector<Box> boxes = randomBoxes(count, unsigned(count));
    expectWhole(buildBvh(boxes, {count / 3}), boxes, {count / 3});
    expectWhole(buildMedianBvh(boxes, {count / 3}), boxes, {count / 3});
  }
}

TEST(Bvh, IsEmptyWithoutBoxes) {
  const Bvh bvh = buildBvh({}, {});
  EXPECT_TRUE(bvh.nodes.empty());
  EXPECT_TRUE(bvh.order.empty());
  EXPECT_EQ(bvh.root.count, 0u);
}

TEST(Bvh, ManyEqualCentroidsSurvive) {
  std::vector<Box> same(100'000, Box{glm::vec3(1), glm::vec3(2)});
  expectWhole(buildBvh(same, {50'000}), same, {50'000});
  expectWhole(buildMedianBvh(same, {50'000}), same, {50'000});
  std::vector<Box> nested(100'000);
  for (size_t i = 0; i < nested.size(); ++i) {
    const float radius = 1 + 1e-6f * float(i);
    nested[i] = {glm::vec3(-radius), glm::vec3(radius)};
  }
  expectWhole(buildBvh(nested, {nested.size()}), nested, {nested.size()});
}

// Boxes nested into one corner make Embree give up under a depth limit: the fallback must take over.
TEST(Bvh, BoxesNestedIntoACornerStayBelowTheDepth) {
  std::vector<Box> boxes;
  for (int i = 0; i < 100'000; ++i) boxes.push_back({glm::vec3(0), glm::vec3(std::pow(0.9999f, float(i)))});
  expectWhole(buildBvh(boxes, {boxes.size()}), boxes, {boxes.size()});
  std::vector<Box> powers;
  for (int k = -40; k <= 40; ++k) {
    const float x = std::ldexp(1.0f, k), r = x / 4;
    powers.push_back({glm::vec3(x - r, -r, -r), glm::vec3(x + r, r, r)});
  }
  expectWhole(buildBvh(powers, {0}), powers, {0});
}

TEST(Bvh, ATightDepthLimitIsKept) {
  const std::vector<Box> boxes = randomBoxes(4000, 7);
  BvhLimits limits;
  limits.maxDepth = 14;
  expectWhole(buildBvh(boxes, {1000}, limits), boxes, {1000}, limits);
}

TEST(Bvh, IsTheSameTwice) {
  const std::vector<Box> boxes = randomBoxes(20'000, 3);
  EXPECT_EQ(buildBvh(boxes, {5000}).order, buildBvh(boxes, {5000}).order);
}

}  // namespace
}  // namespace turner
