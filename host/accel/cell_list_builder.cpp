// Cells are divided as a quadtree while that shortens their lists.
#include "accel/cell_list_builder.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "accel/light_buffer.h"

namespace turner {
namespace {

using gpu::uint;

constexpr int kMostLevels = 7;   // halvings from a coarse cell to fine ones
constexpr int kLeastLevels = 3;  // that a cell may always have
// Costs, in tests of a primitive by a ray: to visit a node and all that is likely to follow, and to make one entry.
constexpr double kNodeCost = 4, kEntryCost = 2.5;
// Nodes of a list are opened (replaced by their children) while it has fewer entries than this. In a small scene nearly
// all are opened down to primitives: a traversal without nodes saves more than a few long lists cost. Cells whose lists
// are longer than kMostTests are divided further to that end.
constexpr size_t kSmallScene = 150'000, kMostOpenedAll = 256, kMostTests = 48;
// In a large scene nodes are opened that cover this share of their cell: nearly all rays would visit them. In a huge
// one fewer, because each test waits for memory that no neighbour has fetched: 10^7 triangles trace 1.2 times faster.
constexpr size_t kHugeScene = 2'000'000, kMostOpened = 48, kMostOpenedHuge = 16;
constexpr float kCovers = 0.8f;
size_t mostOpened(size_t primitives) {
  if (primitives <= kSmallScene) return kMostOpenedAll;
  return primitives <= kHugeScene ? kMostOpened : kMostOpenedHuge;
}

// Something that may be in a cell's list: a node, or one primitive.
struct Candidate : Projection {
  static constexpr uint32_t kNode = UINT32_MAX;
  uint32_t index;          // of the node, or in Bvh::order
  uint32_t edges = kNode;  // of a primitive: its outer edges in the block's store

  bool isNode() const { return edges == kNode; }
};

// Fills the cells of one block of a face.
class CellListBuilder {
 public:
  CellListBuilder(const LightBufferTree& tree, const CubeFace& face, const CellBlockBounds& bounds)
      : tree_(tree), face_(face), bounds_(bounds) {}

  // `side` coarse cells on a side; about so many rays come through each.
  CellBlock build(const FaceRect& rect, int side, double raysInCell) {
    side_ = side;
    block_.levels.resize(size_t(side * side));
    quads_.resize(size_t(side * side));
    cellsLeft_ = quads_.size();
    const FaceRect around = rect.dilated();
    addChild(tree_.bvh.root, around);
    toCoarse(rect, {0, pool_.size(), 0}, 0, 0, side, raysInCell);
    for (size_t cell = 0; cell < quads_.size(); ++cell) layOut(quads_[cell], block_.levels[cell]);
    return std::move(block_);
  }

 private:
  struct Range {
    size_t first, end;  // in the pool
    size_t firstEdges;  // in the store: where those begin that only the range needs
  };
  // A list for a square of fine cells, in units of the finest there can be.
  struct Quad {
    int x, y, level;
    CellList list;
  };

  // The most that an edge's term reaches between two coordinates.
  static float most(float slope, float lo, float hi) { return slope * (slope > 0 ? hi : lo); }

  bool overlaps(const Candidate& candidate, const FaceRect& r) const {
    if (!candidate.rect.overlaps(r)) return false;
    if (candidate.isNode()) return true;
    bool outside = false;
    for (const glm::vec3& e : edges_[candidate.edges])
      outside |= most(e.x, r.uLo, r.uHi) + most(e.y, r.vLo, r.vHi) + e.z < 0;
    return !outside;
  }

  void add(const Box& box, uint32_t index, bool isPrimitive, const FaceRect& rect) {
    Candidate candidate;
    if (!face_.project(box, candidate) || !candidate.rect.overlaps(rect)) return;
    candidate.index = index;
    if (isPrimitive) {
      candidate.edges = uint32_t(edges_.size());
      edges_.emplace_back();
      tree_.prepared.visitElement(tree_.bvh.order[index],
                                  [&](const auto& element) { narrowTo(element, box, candidate, edges_.back()); });
      if (!overlaps(candidate, rect)) {
        edges_.pop_back();
        return;
      }
    }
    pool_.push_back(candidate);
  }

  // A node, or the primitives of a leaf.
  void addChild(const BvhChild& child, const FaceRect& rect) {
    if (child.count == 0) {
      if (!tree_.bvh.nodes.empty()) add(child.box, child.first, false, rect);
      return;
    }
    for (uint32_t i = child.first; i < child.first + child.count; ++i)
      add(tree_.prepared.boxes[tree_.bvh.order[i]], i, true, rect);
  }

  // From an element's box to its own picture.
  template <class Primitive>
  void narrowTo(const Primitive& primitive, const Box& box, Projection& projection, OuterEdges& edges) const {
    narrow(primitive, face_, box, projection, edges);
  }
  void narrowTo(const TrianglePair& pair, const Box& box, Projection&, OuterEdges& edges) const {
    const Scene& scene = tree_.prepared.scene;
    const auto [a, b, c] = scene.cornersOf(pair.first);
    face_.projectEdges({a, b, c, pair.isAlone() ? b : scene.cornersOf(pair.second)[0]}, box, edges);
  }

  // Replaces nodes at the pool's end, from `first` on, by their children where `excess` is positive, those where it is
  // largest first, while they are not too many.
  template <class Excess>
  void open(size_t first, const FaceRect& rect, const Excess& excess) {
    // Those that may be opened are a heap before the others.
    const auto less = [&](const Candidate& a, const Candidate& b) { return excess(a) < excess(b); };
    const auto opens = [&](const Candidate& candidate) { return candidate.isNode() && excess(candidate) > 0; };
    size_t heapEnd = size_t(std::partition(pool_.begin() + long(first), pool_.end(), opens) - pool_.begin());
    std::make_heap(pool_.begin() + long(first), pool_.begin() + long(heapEnd), less);
    while (heapEnd > first && pool_.size() - first < mostOpened_) {
      std::pop_heap(pool_.begin() + long(first), pool_.begin() + long(heapEnd), less);
      --heapEnd;
      const uint32_t node = pool_[heapEnd].index;
      pool_[heapEnd] = pool_.back();
      pool_.pop_back();
      for (const BvhChild& child : tree_.bvh.nodes[node].children) {
        const size_t before = pool_.size();
        addChild(child, rect);
        for (size_t i = before; i < pool_.size(); ++i) {
          if (!opens(pool_[i])) continue;
          std::swap(pool_[i], pool_[heapEnd++]);
          std::push_heap(pool_.begin() + long(first), pool_.begin() + long(heapEnd), less);
        }
      }
    }
  }

  // Finds out which quarters of a cell its candidates overlap: a bit of quarters_ for each, by FaceRect::quarter.
  void findQuarters(const FaceRect& rect, const Range& here) {
    quarters_.resize(here.end);
    const FaceRect lower = rect.quarter(0).dilated(), upper = rect.quarter(3).dilated();
    for (size_t i = here.first; i < here.end; ++i) {
      const Candidate& candidate = pool_[i];
      const FaceRect& r = candidate.rect;
      const auto overlap = [](float lo, float hi, float from, float to) { return unsigned(lo <= to && from <= hi); };
      const unsigned inU =
          overlap(r.uLo, r.uHi, lower.uLo, lower.uHi) * 5 | overlap(r.uLo, r.uHi, upper.uLo, upper.uHi) * 10;
      const unsigned inV =
          overlap(r.vLo, r.vHi, lower.vLo, lower.vHi) * 3 | overlap(r.vLo, r.vHi, upper.vLo, upper.vHi) * 12;
      unsigned quarters = inU & inV;
      if (quarters != 0 && !candidate.isNode()) {
        for (const glm::vec3& e : edges_[candidate.edges]) {
          const float u[2] = {most(e.x, lower.uLo, lower.uHi), most(e.x, upper.uLo, upper.uHi)};
          const float v[2] = {most(e.y, lower.vLo, lower.vHi), most(e.y, upper.vLo, upper.vHi)};
          for (unsigned k = 0; k < 4; ++k) quarters &= ~(unsigned(u[k & 1] + v[k >> 1] + e.z < 0) << k);
        }
      }
      quarters_[i] = uint8_t(quarters);
    }
  }

  // What of a range overlaps a quarter of its cell, copied to the pool's end and opened to the quarter's size.
  Range filter(const Range& from, int quarter, const FaceRect& rect) {
    Range result{pool_.size(), 0, edges_.size()};
    for (size_t i = from.first; i < from.end; ++i)
      if (quarters_[i] >> quarter & 1) pool_.push_back(pool_[i]);
    const float width = rect.uHi - rect.uLo, height = rect.vHi - rect.vLo;
    open(result.first, rect.dilated(), [&](const Candidate& candidate) {
      const FaceRect& r = candidate.rect;
      return std::max(r.uHi - r.uLo - width, r.vHi - r.vLo - height);
    });
    result.end = pool_.size();
    return result;
  }

  // Drops a range from the pool's end.
  void drop(const Range& range) {
    pool_.resize(range.first);
    edges_.resize(range.firstEdges);
  }

  void toCoarse(const FaceRect& rect, const Range& here, int x, int y, int side, double rays) {
    if (side == 1) {
      const size_t cell = size_t(y * side_ + x);
      mostLevels_ = kMostLevels;
      while (mostLevels_ > kLeastLevels && fineCells_ + (size_t(1) << (2 * mostLevels_)) > bounds_.fineCells)
        --mostLevels_;
      // Four times its even share of what is left: most cells need little.
      const size_t entries = block_.entries.size(), left = bounds_.entries - std::min(bounds_.entries, entries);
      mostEntries_ = entries + std::min(left, 4 * left / cellsLeft_--);
      toFine(rect, here, 0, 0, 0, rays, cell);
      fineCells_ += size_t(1) << (2 * block_.levels[cell]);
      return;
    }
    findQuarters(rect, here);
    for (int i = 0; i < 4; ++i) {
      const FaceRect quarter = rect.quarter(i);
      const Range part = filter(here, i, quarter);
      toCoarse(quarter, part, x + (i & 1) * side / 2, y + (i >> 1) * side / 2, side / 2, rays);
      drop(part);
    }
  }

  void toFine(const FaceRect& rect, const Range& here, int level, int x, int y, double rays, size_t cell) {
    const bool divides = level < mostLevels_ && worthDividing(rect, here, rays);
    if (!divides) {
      block_.levels[cell] = std::max(block_.levels[cell], uint8_t(level));
      const int size = 1 << (kMostLevels - level);
      quads_[cell].push_back({x * size, y * size, level, makeList(rect, here)});
      return;
    }
    for (int i = 0; i < 4; ++i) {
      const FaceRect quarter = rect.quarter(i);
      const Range part = filter(here, i, quarter);
      toFine(quarter, part, level + 1, 2 * x + (i & 1), 2 * y + (i >> 1), rays / 4, cell);
      drop(part);
    }
  }

  // Whether quarters would save the rays more than their lists cost. If so, quarters_ tells what is in them.
  bool worthDividing(const FaceRect& rect, const Range& here, double rays) {
    // Cells so small that the kernel's rounding reaches the next one are no use.
    if (std::min(rect.uHi - rect.uLo, rect.vHi - rect.vLo) < 8 * kCellRounding) return false;
    findQuarters(rect, here);
    double now = 0, then = 0;
    size_t entries = 0;
    bool hasNodes = false;
    for (size_t i = here.first; i < here.end; ++i) {
      const bool isNode = pool_[i].isNode();
      const double cost = isNode ? kNodeCost : 1;
      now += cost;
      hasNodes |= isNode;
      const int quarters = std::popcount(quarters_[i]);
      entries += size_t(quarters);
      // A node is opened when its cell gets smaller than itself, and what of it is in a quarter counts for less.
      then += cost * quarters / (isNode ? 8 : 4);
    }
    if (block_.entries.size() + entries > mostEntries_) return false;
    // Lists that would keep nodes are divided as long as that helps at all, until one keeps them nevertheless.
    if (hasNodes && !block_.visitsNodes && opensAll_ && here.end - here.first > kMostTests && then < 0.8 * now)
      return true;
    return rays * (now - then) > 4 * then * kEntryCost;
  }

  CellList makeList(const FaceRect& rect, const Range& here) {
    const size_t first = pool_.size(), firstEdges = edges_.size();
    for (size_t i = here.first; i < here.end; ++i) pool_.push_back(pool_[i]);
    // A node that covers the cell is visited by every ray, and is better replaced by its children.
    const float covers = opensAll_ ? 0 : kCovers * (rect.uHi - rect.uLo) * (rect.vHi - rect.vLo);
    open(first, rect.dilated(), [&](const Candidate& candidate) {
      const FaceRect& r = candidate.rect;
      const float width = std::min(r.uHi, rect.uHi) - std::max(r.uLo, rect.uLo);
      const float height = std::min(r.vHi, rect.vHi) - std::max(r.vLo, rect.vLo);
      const float area = std::max(width, 0.0f) * std::max(height, 0.0f);
      return opensAll_ ? area + 1e-30f : area - covers;
    });
    CellList list{uint(block_.entries.size()), 0};
    for (size_t i = first; i < pool_.size(); ++i) {
      const Candidate& candidate = pool_[i];
      block_.visitsNodes |= candidate.isNode();
      block_.entries.push_back(
          {candidate.isNode() ? candidate.index : gpu::kRefLeaf | tree_.references[candidate.index],
           candidate.distance});
    }
    drop({first, 0, firstEdges});
    list.end = uint(block_.entries.size());
    std::sort(block_.entries.begin() + list.first, block_.entries.end(),
              [](const CellListEntry& a, const CellListEntry& b) {
                return a.distance != b.distance ? a.distance < b.distance : a.reference < b.reference;
              });
    return list;
  }

  // The lists of one coarse cell, cell by cell.
  void layOut(const std::vector<Quad>& quads, int levels) {
    const size_t first = block_.lists.size();
    const int side = 1 << levels, unit = 1 << (kMostLevels - levels);
    block_.lists.resize(first + size_t(side * side));
    for (const Quad& quad : quads) {
      const int size = 1 << (levels - quad.level);
      for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
          block_.lists[first + size_t((quad.y / unit + y) * side + quad.x / unit + x)] = quad.list;
    }
  }

  const LightBufferTree& tree_;
  const CubeFace& face_;
  const CellBlockBounds bounds_;
  const bool opensAll_ = tree_.bvh.order.size() <= kSmallScene;
  const size_t mostOpened_ = mostOpened(tree_.bvh.order.size());
  int mostLevels_ = kMostLevels;
  size_t fineCells_ = 0;
  size_t cellsLeft_ = 0;    // coarse cells still to be filled
  size_t mostEntries_ = 0;  // of the block after the coarse cell in hand
  int side_ = 1;
  // Stacks: each level of the division has its own on top.
  std::vector<Candidate> pool_;
  std::vector<uint8_t> quarters_;  // of the candidates at the same places, see findQuarters
  std::vector<OuterEdges> edges_;  // of primitives in the pool
  std::vector<std::vector<Quad>> quads_;
  CellBlock block_;
};

}  // namespace

CellBlock buildCellBlock(const LightBufferTree& tree, const CubeFace& face, const FaceRect& rect, int side,
                         double raysInCell, const CellBlockBounds& bounds) {
  return CellListBuilder(tree, face, bounds).build(rect, side, raysInCell);
}

}  // namespace turner
