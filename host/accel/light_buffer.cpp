// Boxes are projected onto the faces; cells are divided as a quadtree while that shortens their lists.
#include "accel/light_buffer.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <iterator>

#include "base/errors.h"
#include "base/reserve.h"
#include "base/threads.h"

namespace turner {
namespace {

using gpu::uint;
using gpu::Word4;

constexpr int kMostCoarse = 64;  // coarse cells on a face's side
constexpr int kBlocks = 8;       // blocks of them on a side, each a task
constexpr int kMostLevels = 7;   // halvings from a coarse cell to fine ones
// Bounds on memory that ordinary scenes keep below. Coarse cells of all faces; fine cells and entries of all blocks,
// each of which gets a share: a block that has spent its own divides its cells less, or not at all. Fine cells of a
// block are fewer in any case.
constexpr size_t kMostCoarseCells = 1 << 18;
constexpr size_t kMostFineCells = 1 << 26, kMostFineCellsInBlock = 5 << 14;
constexpr size_t kMostEntries = 1 << 25;
constexpr int kLeastLevels = 3;  // that a cell may always have
// By how much the kernel may miss a cell, in u and v: its division is good to 2.5 ulp, its products to half of one.
constexpr float kCellRounding = 0x1p-19f;
// Costs, in tests of a primitive by a ray: to visit a node and all that is likely to follow, and to make one entry.
constexpr double kNodeCost = 4, kEntryCost = 2.5;
// A list grows up to so many entries by opening its nodes. Of a small scene nearly all are opened to the last shape: a
// walk that meets no nodes is faster by more than a few long lists cost. Where lists are longer than kMostTests, cells
// are divided further for that.
constexpr size_t kSmallScene = 150'000, kMostOpenedAll = 256, kMostTests = 48;
// Of a large scene those nodes are opened that cover so much of their cell: nearly all rays would visit them. Of a huge
// one fewer, because each test waits for memory that no neighbour has fetched: 10^7 triangles trace 1.2 times faster.
constexpr size_t kHugeScene = 2'000'000, kMostOpened = 48, kMostOpenedHuge = 16;
constexpr float kCovers = 0.8f;
size_t mostOpened(size_t primitives) {
  if (primitives <= kSmallScene) return kMostOpenedAll;
  return primitives <= kHugeScene ? kMostOpened : kMostOpenedHuge;
}

struct Rect {
  float uLo, uHi, vLo, vHi;
  bool overlaps(const Rect& other) const {
    return uLo <= other.uHi && other.uLo <= uHi && vLo <= other.vHi && other.vLo <= vHi;
  }
  Rect dilated() const { return {uLo - kCellRounding, uHi + kCellRounding, vLo - kCellRounding, vHi + kCellRounding}; }
  Rect quarter(int i) const {
    const float u = 0.5f * (uLo + uHi), v = 0.5f * (vLo + vHi);
    return {i & 1 ? u : uLo, i & 1 ? uHi : u, i & 2 ? v : vLo, i & 2 ? vHi : v};
  }
};

// Where x u + y v + z < 0 on one of these, all of a pair of triangles before the point is outside.
using OuterEdges = std::array<glm::vec3, 4>;

// Something that may be in a cell's list: a node, or one shape.
struct Candidate {
  static constexpr uint32_t kNode = UINT32_MAX;
  Rect rect;               // of its box on the face
  float distance;          // least along the face's axis
  uint32_t index;          // of the node, or in Bvh::order
  uint32_t edges = kNode;  // of a shape: its outer edges in the block's store

  bool isNode() const { return edges == kNode; }
};

// Of a pair: the first triangle has 0, 1, 2, the second 3, 1, 2; of one alone 3 is 1, so that one edge is a point.
using Corners = std::array<glm::dvec3, 4>;

struct Interval {
  double lo, hi;
};

// The quotients of two intervals, the divisor's part above 0; of what has no bound there, at most `far`.
Interval quotient(const Interval& a, const Interval& c) {
  constexpr double kFar = 4;
  const double least = std::max(c.lo, 1e-30);
  const double lo = a.lo / (a.lo < 0 ? least : c.hi), hi = a.hi / (a.hi > 0 ? least : c.hi);
  return {std::clamp(lo, -kFar, kFar), std::clamp(hi, -kFar, kFar)};
}

// One face of the cube around a point.
class Face {
 public:
  Face(const glm::dvec3& point, int face) : point_(point), axis_(face / 2), negative_(face % 2 == 1) {}

  // False if the box lies behind the point.
  bool project(const Box& box, Candidate& out) const {
    Interval c = along(box, axis_), a = along(box, (axis_ + 1) % 3), b = along(box, (axis_ + 2) % 3);
    if (negative_) c = {-c.hi, -c.lo}, a = {-a.hi, -a.lo}, b = {-b.hi, -b.lo};
    if (!(c.hi > 0)) return false;
    const Interval u = quotient(a, c), v = quotient(b, c);
    out.rect = {float(u.lo), float(u.hi), float(v.lo), float(v.hi)};
    out.distance = c.lo > 0 ? float(c.lo * (1 - 0x1p-20)) : 0.0f;
    return true;
  }

  // The edges of a pair whose padded box was projected.
  void projectEdges(const Corners& corners, const Box& box, OuterEdges& edges) const {
    std::array<glm::dvec2, 4> p;
    double nearest = INFINITY, farthestAside = 0;
    glm::dvec3 lo(INFINITY), hi(-INFINITY);
    for (size_t i = 0; i < 4; ++i) {
      const glm::dvec3 d = corners[i] - point_;
      const double c = negative_ ? -d[axis_] : d[axis_];
      if (!(c > 0)) return;
      nearest = std::min(nearest, c);
      p[i] = glm::dvec2(d[(axis_ + 1) % 3], d[(axis_ + 2) % 3]) / d[axis_];
      farthestAside = std::max({farthestAside, std::abs(p[i].x), std::abs(p[i].y)});
      lo = glm::min(lo, corners[i]);
      hi = glm::max(hi, corners[i]);
    }
    // The corners may be off by as much as the box is padded, the largest pad on any axis; seen from the point in u and
    // v:
    const glm::dvec3 pad = (glm::dvec3(box.hi) - glm::dvec3(box.lo)) - (hi - lo);
    const double margin = 2 * std::max({pad.x, pad.y, pad.z}) / nearest * (1 + farthestAside);
    if (!(margin < 1)) return;
    // Around the pair: each edge with the corner of its own triangle, which tells the inner side.
    constexpr size_t kEdges[4][3] = {{0, 1, 2}, {1, 3, 2}, {3, 2, 1}, {2, 0, 1}};
    for (size_t i = 0; i < 4; ++i) {
      const glm::dvec2 a = p[kEdges[i][0]], along = p[kEdges[i][1]] - a, inward = p[kEdges[i][2]] - a;
      const double area = along.x * inward.y - along.y * inward.x, length = std::abs(along.x) + std::abs(along.y);
      if (!(std::abs(area) > 1e-14)) continue;
      const glm::dvec2 n = glm::dvec2(-along.y, along.x) * ((area > 0 ? 1 : -1) / length);
      double least = INFINITY;
      for (const glm::dvec2& corner : p) least = std::min(least, glm::dot(n, corner));
      // A float's rounding of all three terms is within the last addend.
      const double z = -least + margin + 0x1p-20 * (2 + 2 * farthestAside);
      edges[i] = {float(n.x), float(n.y), float(z)};
    }
  }

 private:
  Interval along(const Box& box, int axis) const { return {box.lo[axis] - point_[axis], box.hi[axis] - point_[axis]}; }

  glm::dvec3 point_;
  int axis_;
  bool negative_;
};

struct Entry {
  uint reference;
  float distance;
};

struct List {
  uint first = 0, end = 0;  // in the block's entries
};

// A square of coarse cells. Those that were divided less than others have the same list several times.
struct Block {
  std::vector<uint8_t> levels;  // of each coarse cell, row by row: it has 2^levels fine cells on a side
  std::vector<List> lists;      // of the fine cells of each coarse cell, row by row
  std::vector<Entry> entries;
  bool visitsNodes = false;
};

// The share of one block.
struct BlockBounds {
  size_t fineCells, entries;
};

// Fills the cells of one block of a face.
class BlockBuilder {
 public:
  BlockBuilder(const LightBufferTree& tree, const Face& face, const BlockBounds& bounds)
      : tree_(tree), face_(face), bounds_(bounds) {}

  // `side` coarse cells on a side; about so many rays come through each.
  Block build(const Rect& rect, int side, double raysInCell) {
    side_ = side;
    block_.levels.resize(size_t(side * side));
    quads_.resize(size_t(side * side));
    cellsLeft_ = quads_.size();
    const Rect around = rect.dilated();
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
    List list;
  };

  // The most that an edge's term reaches between two coordinates.
  static float most(float slope, float lo, float hi) { return slope * (slope > 0 ? hi : lo); }

  bool overlaps(const Candidate& candidate, const Rect& r) const {
    if (!candidate.rect.overlaps(r)) return false;
    if (candidate.isNode()) return true;
    bool outside = false;
    for (const glm::vec3& e : edges_[candidate.edges])
      outside |= most(e.x, r.uLo, r.uHi) + most(e.y, r.vLo, r.vHi) + e.z < 0;
    return !outside;
  }

  void add(const Box& box, uint32_t index, bool isPrimitive, const Rect& rect) {
    Candidate candidate;
    if (!face_.project(box, candidate) || !candidate.rect.overlaps(rect)) return;
    candidate.index = index;
    if (isPrimitive) {
      candidate.edges = uint32_t(edges_.size());
      edges_.emplace_back();
      const uint32_t primitive = tree_.bvh.order[index];
      if (primitive >= tree_.prepared.firstPair()) {
        face_.projectEdges(cornersOf(primitive), box, edges_.back());
        if (!overlaps(candidate, rect)) {
          edges_.pop_back();
          return;
        }
      }
    }
    pool_.push_back(candidate);
  }

  // A node, or the shapes of a leaf.
  void addChild(const BvhChild& child, const Rect& rect) {
    if (child.count == 0) {
      if (!tree_.bvh.nodes.empty()) add(child.box, child.first, false, rect);
      return;
    }
    for (uint32_t i = child.first; i < child.first + child.count; ++i)
      add(tree_.prepared.boxes[tree_.bvh.order[i]], i, true, rect);
  }

  Corners cornersOf(uint32_t primitive) const {
    const TrianglePair& pair = tree_.prepared.pairs[primitive - tree_.prepared.firstPair()];
    const std::vector<Triangle>& triangles = tree_.prepared.scene.triangles;
    const auto& [a, b, c] = triangles[pair.first].vertices;
    return {a, b, c, pair.isAlone() ? b : triangles[pair.second].vertices[0]};
  }

  // Replaces nodes at the pool's end, from `first` on, by their children where `excess` is positive, those where it is
  // largest first, while they are not too many.
  template <class Excess>
  void open(size_t first, const Rect& rect, const Excess& excess) {
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

  // Finds out which quarters of a cell its candidates overlap: a bit of quarters_ for each, by Rect::quarter.
  void findQuarters(const Rect& rect, const Range& here) {
    quarters_.resize(here.end);
    const Rect lower = rect.quarter(0).dilated(), upper = rect.quarter(3).dilated();
    for (size_t i = here.first; i < here.end; ++i) {
      const Candidate& candidate = pool_[i];
      const Rect& r = candidate.rect;
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
  Range filter(const Range& from, int quarter, const Rect& rect) {
    Range result{pool_.size(), 0, edges_.size()};
    for (size_t i = from.first; i < from.end; ++i)
      if (quarters_[i] >> quarter & 1) pool_.push_back(pool_[i]);
    const float width = rect.uHi - rect.uLo, height = rect.vHi - rect.vLo;
    open(result.first, rect.dilated(), [&](const Candidate& candidate) {
      const Rect& r = candidate.rect;
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

  void toCoarse(const Rect& rect, const Range& here, int x, int y, int side, double rays) {
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
      const Rect quarter = rect.quarter(i);
      const Range part = filter(here, i, quarter);
      toCoarse(quarter, part, x + (i & 1) * side / 2, y + (i >> 1) * side / 2, side / 2, rays);
      drop(part);
    }
  }

  void toFine(const Rect& rect, const Range& here, int level, int x, int y, double rays, size_t cell) {
    const bool divides = level < mostLevels_ && worthDividing(rect, here, rays);
    if (!divides) {
      block_.levels[cell] = std::max(block_.levels[cell], uint8_t(level));
      const int size = 1 << (kMostLevels - level);
      quads_[cell].push_back({x * size, y * size, level, makeList(rect, here)});
      return;
    }
    for (int i = 0; i < 4; ++i) {
      const Rect quarter = rect.quarter(i);
      const Range part = filter(here, i, quarter);
      toFine(quarter, part, level + 1, 2 * x + (i & 1), 2 * y + (i >> 1), rays / 4, cell);
      drop(part);
    }
  }

  // Whether quarters would save the rays more than their lists cost. If so, quarters_ tells what is in them.
  bool worthDividing(const Rect& rect, const Range& here, double rays) {
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

  List makeList(const Rect& rect, const Range& here) {
    const size_t first = pool_.size(), firstEdges = edges_.size();
    for (size_t i = here.first; i < here.end; ++i) pool_.push_back(pool_[i]);
    // A node that covers the cell is visited by every ray, and is better replaced by its children.
    const float covers = opensAll_ ? 0 : kCovers * (rect.uHi - rect.uLo) * (rect.vHi - rect.vLo);
    open(first, rect.dilated(), [&](const Candidate& candidate) {
      const Rect& r = candidate.rect;
      const float width = std::min(r.uHi, rect.uHi) - std::max(r.uLo, rect.uLo);
      const float height = std::min(r.vHi, rect.vHi) - std::max(r.vLo, rect.vLo);
      const float area = std::max(width, 0.0f) * std::max(height, 0.0f);
      return opensAll_ ? area + 1e-30f : area - covers;
    });
    List list{uint(block_.entries.size()), 0};
    for (size_t i = first; i < pool_.size(); ++i) {
      const Candidate& candidate = pool_[i];
      block_.visitsNodes |= candidate.isNode();
      block_.entries.push_back(
          {candidate.isNode() ? candidate.index : gpu::kRefLeaf | tree_.references[candidate.index],
           candidate.distance});
    }
    drop({first, 0, firstEdges});
    list.end = uint(block_.entries.size());
    std::sort(block_.entries.begin() + list.first, block_.entries.end(), [](const Entry& a, const Entry& b) {
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
  const Face& face_;
  const BlockBounds bounds_;
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
  std::vector<OuterEdges> edges_;  // of shapes in the pool
  std::vector<std::vector<Quad>> quads_;
  Block block_;
};

// The word of gpu::LightBufferFace; the window is a square.
Word4 faceWord(const Rect& window, int coarse, size_t firstCell) {
  if (firstCell >= size_t(1) << 24) throw InputError("the scene has more lights than the kernel can number");
  const float width = window.uHi - window.uLo;
  return std::bit_cast<Word4>(gpu::LightBufferFace{
      {window.uLo, window.vLo}, width > 0 ? float(coarse) / width : 0.0f, uint(coarse) | uint(firstCell) << 8});
}

// A face and what is to be done for it.
struct PlannedFace {
  Rect window{1, -1, 1, -1};   // empty: no ray through this face meets anything
  std::vector<Rect> occupied;  // what stands in it, roughly
  int coarse = 1;              // cells on a side
  std::vector<Block> blocks;   // row by row, blocksOnASide() squared
  bool isEmpty() const { return !(window.uLo < window.uHi && window.vLo < window.vHi); }
  int blocksOnASide() const { return std::min(kBlocks, coarse); }
  Rect blockRect(int block) const {
    const int across = blocksOnASide(), side = coarse / across;
    return cells(block % across * side, block / across * side, side);
  }
  Rect cells(int x, int y, int size) const {
    const float width = (window.uHi - window.uLo) / float(coarse), height = (window.vHi - window.vLo) / float(coarse);
    return {window.uLo + float(x) * width, window.uLo + float(x + size) * width, window.vLo + float(y) * height,
            window.vLo + float(y + size) * height};
  }
};

// The upper part of the tree, level by level: leaves, and nodes that hold all the rest.
std::vector<BvhChild> topOf(const Bvh& bvh) {
  constexpr size_t kMost = 512;
  std::vector<BvhChild> top, queue = {bvh.root};
  size_t next = 0;
  for (; next < queue.size() && top.size() + queue.size() - next < kMost; ++next) {
    const BvhChild child = queue[next];
    if (child.count > 0) {
      top.push_back(child);
      continue;
    }
    const Bvh::Node& node = bvh.nodes[child.first];
    queue.insert(queue.end(), std::begin(node.children), std::end(node.children));
  }
  top.insert(top.end(), queue.begin() + long(next), queue.end());
  return top;
}

// Shrinks a face's window to what holds something.
PlannedFace planFace(const Face& face, const FaceWindow& window, std::span<const BvhChild> top, size_t rays,
                     int mostCoarse) {
  PlannedFace plan;
  const Rect whole{float(window.uLo) - kCellRounding, float(window.uHi) + kCellRounding,
                   float(window.vLo) - kCellRounding, float(window.vHi) + kCellRounding};
  if (window.uLo > window.uHi || window.vLo > window.vHi) return plan;
  for (const BvhChild& child : top) {
    Candidate projected;
    if (!face.project(child.box, projected) || !projected.rect.overlaps(whole)) continue;
    const Rect r = projected.rect.dilated();
    plan.occupied.push_back(r);
    Rect& w = plan.window;
    w = {std::min(w.uLo, r.uLo), std::max(w.uHi, r.uHi), std::min(w.vLo, r.vLo), std::max(w.vHi, r.vHi)};
  }
  Rect& w = plan.window;
  w = {std::max(w.uLo, whole.uLo), std::min(w.uHi, whole.uHi), std::max(w.vLo, whole.vLo), std::min(w.vHi, whole.vHi)};
  // A square, so that the kernel needs one scale; a cell is at least four times what the kernel may miss.
  const float side = std::max({w.uHi - w.uLo, w.vHi - w.vLo, 8 * kCellRounding});
  if (w.uLo < w.uHi && w.vLo < w.vHi) w = {w.uLo, w.uLo + side, w.vLo, w.vLo + side};
  // A coarse cell is for some hundred rays.
  while (plan.coarse < mostCoarse && 256 * size_t(plan.coarse) * size_t(plan.coarse) < rays &&
         float(2 * plan.coarse) * 4 * kCellRounding <= side)
    plan.coarse *= 2;
  return plan;
}

// Coarse cells that something stands in.
size_t occupiedCells(const PlannedFace& face) {
  size_t count = 0;
  for (int y = 0; y < face.coarse; ++y)
    for (int x = 0; x < face.coarse; ++x) {
      const Rect cell = face.cells(x, y, 1);
      count += std::any_of(face.occupied.begin(), face.occupied.end(), [&](const Rect& r) { return r.overlaps(cell); });
    }
  return count;
}

}  // namespace

LightBuffers buildLightBuffers(std::span<const LightBufferPoint> points, const LightBufferTree& tree) {
  std::vector<PlannedFace> faces(points.size() * 6);
  struct Task {
    size_t face;
    int block;
    double raysInCell;
    size_t occupants;  // how much of the tree's top stands there
  };
  std::vector<Task> tasks;
  size_t occupants = 0;
  if (!tree.bvh.order.empty()) {
    const std::vector<BvhChild> top = topOf(tree.bvh);
    // The more lights, the fewer cells for each.
    int mostCoarse = kMostCoarse;
    while (mostCoarse > 1 && faces.size() * size_t(mostCoarse * mostCoarse) > kMostCoarseCells) mostCoarse /= 2;
    for (size_t p = 0; p < points.size(); ++p) {
      size_t occupied = 0;
      for (size_t f = 6 * p; f < 6 * p + 6; ++f) {
        faces[f] =
            planFace(Face(points[p].position, int(f % 6)), points[p].windows[f % 6], top, points[p].rays, mostCoarse);
        if (!faces[f].isEmpty()) occupied += occupiedCells(faces[f]);
      }
      for (size_t f = 6 * p; f < 6 * p + 6; ++f) {
        if (faces[f].isEmpty()) continue;
        const int blocks = faces[f].blocksOnASide() * faces[f].blocksOnASide();
        faces[f].blocks.resize(size_t(blocks));
        for (int block = 0; block < blocks; ++block) {
          const Rect rect = faces[f].blockRect(block);
          const size_t here = 1 + size_t(std::count_if(faces[f].occupied.begin(), faces[f].occupied.end(),
                                                       [&](const Rect& r) { return r.overlaps(rect); }));
          tasks.push_back({f, block, double(points[p].rays) / double(std::max<size_t>(1, occupied)), here});
          occupants += here;
        }
      }
    }
    onAllCores(tasks.size(), [&](size_t i) {
      const Task& task = tasks[i];
      PlannedFace& plan = faces[task.face];
      const Face face(points[task.face / 6].position, int(task.face % 6));
      const BlockBounds bounds{std::min(kMostFineCellsInBlock, kMostFineCells / tasks.size()),
                               kMostEntries / 2 / tasks.size() + kMostEntries / 2 * task.occupants / occupants};
      plan.blocks[size_t(task.block)] =
          BlockBuilder(tree, face, bounds)
              .build(plan.blockRect(task.block), plan.coarse / plan.blocksOnASide(), task.raysInCell);
    });
  }

  // Rows: faces, coarse cells, fine cells, entries.
  LightBuffers lightBuffers;
  lightBuffers.visitsNodes.resize(points.size());
  size_t coarse = faces.size(), fine = coarse + 1, entry = 0;
  for (const PlannedFace& face : faces) fine += face.blocks.empty() ? 0 : size_t(face.coarse * face.coarse);
  entry = fine + 1;
  const size_t nowhere = coarse;
  const uint emptyList = uint(fine);
  for (const PlannedFace& face : faces)
    for (const Block& block : face.blocks) entry += block.lists.size();
  size_t entries = 0;
  for (const PlannedFace& face : faces)
    for (const Block& block : face.blocks) entries += block.entries.size();
  reservePrefaulted(lightBuffers.rows, entry + entries / 2 + 2);
  lightBuffers.rows.resize(entry);
  lightBuffers.rows[nowhere] = Word4{emptyList, 1};
  lightBuffers.rows[emptyList] = Word4{0, 0};
  ++coarse;
  ++fine;
  for (size_t p = 0; p < points.size(); ++p) {
    bool meets = false;
    for (size_t q = 0; q < points.size(); ++q) {
      if (points[q].kernelTraversal != points[p].kernelTraversal) continue;
      meets |= points[q].traversalVisitsNodes;
      for (size_t f = 6 * q; f < 6 * q + 6; ++f)
        for (const Block& block : faces[f].blocks) meets |= block.visitsNodes;
    }
    lightBuffers.visitsNodes[p] = meets;
  }
  std::vector<Entry> all;
  reservePrefaulted(all, entries);
  for (size_t f = 0; f < faces.size(); ++f) {
    PlannedFace& face = faces[f];
    if (face.blocks.empty()) {
      lightBuffers.rows[f] = faceWord({}, 1, nowhere);
      continue;
    }
    lightBuffers.rows[f] = faceWord(face.window, face.coarse, coarse);
    const int across = face.blocksOnASide(), side = face.coarse / across;
    for (size_t b = 0; b < face.blocks.size(); ++b) {
      Block& block = face.blocks[b];
      const uint first = uint(2 * entry + all.size());
      size_t list = 0;
      for (size_t cell = 0; cell < block.levels.size(); ++cell) {
        const size_t x = b % size_t(across) * size_t(side) + cell % size_t(side);
        const size_t y = b / size_t(across) * size_t(side) + cell / size_t(side);
        lightBuffers.rows[coarse + y * size_t(face.coarse) + x] = Word4{uint(fine), 1u << block.levels[cell]};
        for (size_t end = list + (size_t(1) << (2 * block.levels[cell])); list < end; ++list) {
          const List& l = block.lists[list];
          const auto begin = block.entries.begin();
          const auto isSphere = [](const Entry& e) { return (e.reference & gpu::kRefTriangle) == 0; };
          const auto triangles = lightBuffers.visitsNodes[f / 6]
                                     ? begin + l.first
                                     : std::stable_partition(begin + l.first, begin + l.end, isSphere);
          lightBuffers.rows[fine++] = Word4{first + l.first, first + l.end, first + uint(triangles - begin)};
        }
      }
      all.insert(all.end(), block.entries.begin(), block.entries.end());
      block = {};  // memory for the rows
    }
    coarse += size_t(face.coarse * face.coarse);
  }
  for (size_t i = 0; i < all.size(); i += 2) {
    const Entry a = all[i], b = i + 1 < all.size() ? all[i + 1] : Entry{gpu::kRefNone, 0};
    lightBuffers.rows.push_back(
        {a.reference, std::bit_cast<uint>(a.distance), b.reference, std::bit_cast<uint>(b.distance)});
  }
  lightBuffers.rows.push_back({});  // the kernel may look at the entry behind the last one
  return lightBuffers;
}

LightBuffers wholeTreeLightBuffers(std::span<const LightBufferPoint> points, const LightBufferTree& tree) {
  const Bvh& bvh = tree.bvh;
  LightBuffers lightBuffers;
  const bool isNode = bvh.root.count == 0 && !bvh.nodes.empty();
  lightBuffers.visitsNodes.assign(points.size(), true);  // its lists are not sorted by kind
  // Every face has one cell, all with the same list.
  const uint coarse = uint(points.size() * gpu::kLightBufferFaces), fine = coarse + 1, list = 2 * (fine + 1);
  for (size_t f = 0; f < points.size() * gpu::kLightBufferFaces; ++f)
    lightBuffers.rows.push_back(faceWord({}, 1, coarse));
  lightBuffers.rows.push_back(Word4{fine, 1});
  std::vector<uint> all;
  if (isNode) all = {bvh.root.first};
  for (uint32_t i = 0; i < bvh.root.count; ++i) all.push_back(gpu::kRefLeaf | tree.references[bvh.root.first + i]);
  lightBuffers.rows.push_back(Word4{list, list + uint(all.size()), list});
  for (size_t i = 0; i < all.size(); i += 2)
    lightBuffers.rows.push_back(Word4{all[i], 0, i + 1 < all.size() ? all[i + 1] : gpu::kRefNone, 0});
  lightBuffers.rows.push_back({});  // the kernel may look at the entry behind the last one
  return lightBuffers;
}

}  // namespace turner
