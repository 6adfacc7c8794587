// Embree's callbacks build a tree of pointers; flattening it, depth first, splits what a leaf may not hold.
#include "accel/bvh.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <memory>
#include <new>
#include <numeric>
#include <string>

#include "base/errors.h"
#include "base/reserve.h"
#include "base/threads.h"

namespace turner {
namespace {

Box unite(const Box& a, const Box& b) {
  return {glm::min(a.lo, b.lo), glm::max(a.hi, b.hi)};
}

// Writes the tree into its final arrays while a builder walks its own, depth first.
class Flattener {
 public:
  Flattener(std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits)
      : boxes_(boxes), kinds_(kinds), limits_(limits) {
    reservePrefaulted(bvh_.order, boxes.size());
    // Embree makes about a third as many nodes as boxes; what is not prefaulted takes no memory until it is written.
    bvh_.nodes.reserve(boxes.size() / 2 + boxes.size() / 8);
    prefault(bvh_.nodes.data(), boxes.size() / 3 * sizeof(Bvh::Node));
  }

  // A node whose children are written by the two functions, which return BvhChild and take their depth.
  template <class First, class Second>
  BvhChild node(int depth, First&& first, Second&& second) {
    bvh_.depth = std::max(bvh_.depth, depth);
    const uint32_t index = uint32_t(bvh_.nodes.size());
    bvh_.nodes.emplace_back();
    const BvhChild a = first(depth + 1);
    const BvhChild b = second(depth + 1);
    bvh_.nodes[index] = {{a, b}};
    return {unite(a.box, b.box), index, 0};
  }

  // A leaf; or nodes down to leaves that are small enough and of one kind.
  BvhChild leaf(int depth, std::span<uint32_t> entries) {
    std::sort(entries.begin(), entries.end());
    // Where another kind begins, if one does.
    const auto start = std::upper_bound(kinds_.begin(), kinds_.end(), entries.front());
    const bool mixed = start != kinds_.end() && *start <= entries.back();
    if (mixed || entries.size() > limits_.maxLeafSize) {
      const size_t cut = mixed ? size_t(std::lower_bound(entries.begin(), entries.end(), *start) - entries.begin())
                               : entries.size() / 2;
      return node(
          depth, [&](int below) { return leaf(below, entries.first(cut)); },
          [&](int below) { return leaf(below, entries.subspan(cut)); });
    }
    BvhChild child{boxes_[entries[0]], uint32_t(bvh_.order.size()), uint32_t(entries.size())};
    for (const uint32_t entry : entries) {
      child.box = unite(child.box, boxes_[entry]);
      bvh_.order.push_back(entry);
    }
    return child;
  }

  Bvh finish(const BvhChild& root) {
    bvh_.root = root;
    return std::move(bvh_);
  }

 private:
  std::span<const Box> boxes_;
  const KindStarts& kinds_;
  BvhLimits limits_;
  Bvh bvh_;
};

// --- Embree's builder: its callbacks make a tree of these in its thread-local memory ---
struct BuildNode {
  BuildNode* children[2] = {nullptr, nullptr};  // of an inner node
  uint32_t count = 0;                           // of a leaf, whose entries stand behind this structure
  uint32_t* entries() { return reinterpret_cast<uint32_t*>(this + 1); }
};

void* createNode(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode;
}

void setChildren(void* node, void** children, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i)
    static_cast<BuildNode*>(node)->children[i] = static_cast<BuildNode*>(children[i]);
}

// Boxes are united again while flattening, from what the leaves really hold.
void setBounds(void*, const RTCBounds**, unsigned, void*) {}

void* createLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t count, void*) {
  void* memory = rtcThreadLocalAlloc(allocator, sizeof(BuildNode) + count * sizeof(uint32_t), 16);
  BuildNode* leaf = new (memory) BuildNode;
  leaf->count = uint32_t(count);
  for (size_t i = 0; i < count; ++i) leaf->entries()[i] = primitives[i].primID;
  return leaf;
}

BvhChild flatten(Flattener& out, BuildNode& node, int depth) {
  if (node.count > 0) return out.leaf(depth, {node.entries(), node.count});
  return out.node(
      depth, [&](int below) { return flatten(out, *node.children[0], below); },
      [&](int below) { return flatten(out, *node.children[1], below); });
}

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseBvh {
  void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
};

// False where Embree gives up: boxes nested into a corner, for one, need more depth than it is allowed.
bool buildWithEmbree(std::span<const Box> boxes, const BvhLimits& limits, Flattener& out, BvhChild& root) {
  const std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice> device(rtcNewDevice(nullptr));
  if (!device) {
    const RTCError error = rtcGetDeviceError(nullptr);
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    throw RunError("Embree cannot start: rtcNewDevice failed with code " + std::to_string(int(error)));
  }
  const std::unique_ptr<std::remove_pointer_t<RTCBVH>, ReleaseBvh> bvh(rtcNewBVH(device.get()));
  if (!bvh) throw RunError("Embree cannot build: rtcNewBVH failed");

  std::vector<RTCBuildPrimitive> primitives;
  reservePrefaulted(primitives, boxes.size());
  primitives.resize(boxes.size());
  forAll(boxes.size(), [&](size_t i) {
    const Box& box = boxes[i];
    primitives[i] = {box.lo.x, box.lo.y, box.lo.z, 0, box.hi.x, box.hi.y, box.hi.z, uint32_t(i)};
  });

  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.byteSize = sizeof arguments;
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = 2;
  // Leaves of several kinds are split once or twice more below, and oversized ones a few times.
  arguments.maxDepth = unsigned(limits.maxDepth - 6);
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = limits.maxLeafSize;
  // A test costs the kernel about as much as a visit, but leaves of several primitives make smaller trees, sooner, that
  // are as fast: 10^6 triangles build in 0.6 of the time.
  arguments.traversalCost = 1;
  arguments.intersectionCost = 0.25f;
  arguments.bvh = bvh.get();
  arguments.primitives = primitives.data();
  arguments.primitiveCount = primitives.size();
  arguments.primitiveArrayCapacity = primitives.size();
  arguments.createNode = createNode;
  arguments.setNodeChildren = setChildren;
  arguments.setNodeBounds = setBounds;
  arguments.createLeaf = createLeaf;
  auto* top = static_cast<BuildNode*>(rtcBuildBVH(&arguments));
  if (!top) {
    const RTCError error = rtcGetDeviceError(device.get());
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw RunError("out of memory: Embree's rtcBuildBVH");
    return false;
  }
  root = flatten(out, *top, 1);
  return true;
}

BvhChild splitAtMedian(Flattener& out, std::span<const Box> boxes, std::span<uint32_t> entries, int depth) {
  if (entries.size() <= 2) return out.leaf(depth, entries);
  Box centroids{glm::vec3(INFINITY), glm::vec3(-INFINITY)};
  const auto centroid = [&](uint32_t entry) { return 0.5f * boxes[entry].lo + 0.5f * boxes[entry].hi; };
  for (const uint32_t entry : entries) centroids = unite(centroids, {centroid(entry), centroid(entry)});
  const glm::vec3 extent = centroids.hi - centroids.lo;
  const int axis = extent.x >= extent.y ? (extent.x >= extent.z ? 0 : 2) : (extent.y >= extent.z ? 1 : 2);
  const size_t middle = entries.size() / 2;
  std::nth_element(entries.begin(), entries.begin() + std::ptrdiff_t(middle), entries.end(),
                   [&](uint32_t a, uint32_t b) { return centroid(a)[axis] < centroid(b)[axis]; });
  return out.node(
      depth, [&](int below) { return splitAtMedian(out, boxes, entries.first(middle), below); },
      [&](int below) { return splitAtMedian(out, boxes, entries.subspan(middle), below); });
}

}  // namespace

Bvh buildMedianBvh(std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits) {
  if (boxes.empty()) return {};
  Flattener out(boxes, kinds, limits);
  std::vector<uint32_t> entries(boxes.size());
  std::iota(entries.begin(), entries.end(), 0u);
  const BvhChild root = splitAtMedian(out, boxes, entries, 1);
  return out.finish(root);
}

Bvh buildBvh(std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits) {
  if (boxes.empty()) return {};
  Flattener out(boxes, kinds, limits);
  BvhChild root;
  if (buildWithEmbree(boxes, limits, out, root)) {
    Bvh bvh = out.finish(root);
    if (bvh.depth <= limits.maxDepth) return bvh;
  }
  return buildMedianBvh(boxes, kinds, limits);
}

}  // namespace turner
