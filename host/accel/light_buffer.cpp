// Plans the faces, has their blocks built, and writes the rows.
#include "accel/light_buffer.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <iterator>

#include "accel/cell_list_builder.h"
#include "base/errors.h"
#include "base/reserve.h"
#include "base/threads.h"
#include "primitives/cube_face.h"

namespace turner {
namespace {

using gpu::uint;
using gpu::Word4;

constexpr int kMostCoarse = 64;  // coarse cells on a face's side
constexpr int kBlocks = 8;       // blocks of them on a side, each a task
// Bounds on memory that ordinary scenes keep below. Coarse cells of all faces; fine cells and entries of all blocks,
// each of which gets a share: a block that has spent its own divides its cells less, or not at all. Fine cells of a
// block are fewer in any case.
constexpr size_t kMostCoarseCells = 1 << 18;
constexpr size_t kMostFineCells = 1 << 26, kMostFineCellsInBlock = 5 << 14;
constexpr size_t kMostEntries = 1 << 25;

// The word of gpu::LightBufferFace; the window is a square.
Word4 faceWord(const FaceRect& window, int coarse, size_t firstCell) {
  if (firstCell >= size_t(1) << 24) throw InputError("the scene has more lights than the kernel can number");
  const float width = window.uHi - window.uLo;
  return std::bit_cast<Word4>(gpu::LightBufferFace{
      {window.uLo, window.vLo}, width > 0 ? float(coarse) / width : 0.0f, uint(coarse) | uint(firstCell) << 8});
}

// A face and what is to be done for it.
struct PlannedFace {
  FaceRect window{1, -1, 1, -1};   // empty: no ray through this face meets anything
  std::vector<FaceRect> occupied;  // projections of the tree's top
  int coarse = 1;                  // cells on a side
  std::vector<CellBlock> blocks;   // row by row, blocksOnASide() squared
  bool isEmpty() const { return !(window.uLo < window.uHi && window.vLo < window.vHi); }
  int blocksOnASide() const { return std::min(kBlocks, coarse); }
  FaceRect blockRect(int block) const {
    const int across = blocksOnASide(), side = coarse / across;
    return cells(block % across * side, block / across * side, side);
  }
  FaceRect cells(int x, int y, int size) const {
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
PlannedFace planFace(const CubeFace& face, const FaceWindow& window, std::span<const BvhChild> top, size_t rays,
                     int mostCoarse) {
  PlannedFace plan;
  const FaceRect whole{float(window.uLo) - kCellRounding, float(window.uHi) + kCellRounding,
                       float(window.vLo) - kCellRounding, float(window.vHi) + kCellRounding};
  if (window.uLo > window.uHi || window.vLo > window.vHi) return plan;
  for (const BvhChild& child : top) {
    Projection projected;
    if (!face.project(child.box, projected) || !projected.rect.overlaps(whole)) continue;
    const FaceRect r = projected.rect.dilated();
    plan.occupied.push_back(r);
    FaceRect& w = plan.window;
    w = {std::min(w.uLo, r.uLo), std::max(w.uHi, r.uHi), std::min(w.vLo, r.vLo), std::max(w.vHi, r.vHi)};
  }
  FaceRect& w = plan.window;
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

// Coarse cells that the tree's top overlaps.
size_t occupiedCells(const PlannedFace& face) {
  size_t count = 0;
  for (int y = 0; y < face.coarse; ++y)
    for (int x = 0; x < face.coarse; ++x) {
      const FaceRect cell = face.cells(x, y, 1);
      count +=
          std::any_of(face.occupied.begin(), face.occupied.end(), [&](const FaceRect& r) { return r.overlaps(cell); });
    }
  return count;
}

// The faces of all points, in the order of gpu::LightBufferFace.
std::vector<PlannedFace> planFaces(std::span<const LightBufferPoint> points, const Bvh& bvh) {
  std::vector<PlannedFace> faces(points.size() * 6);
  if (bvh.order.empty()) return faces;
  const std::vector<BvhChild> top = topOf(bvh);
  // The more lights, the fewer cells for each.
  int mostCoarse = kMostCoarse;
  while (mostCoarse > 1 && faces.size() * size_t(mostCoarse * mostCoarse) > kMostCoarseCells) mostCoarse /= 2;
  for (size_t f = 0; f < faces.size(); ++f) {
    const LightBufferPoint& point = points[f / 6];
    faces[f] = planFace(CubeFace(point.position, int(f % 6)), point.windows[f % 6], top, point.rays, mostCoarse);
  }
  return faces;
}

// A block to build.
struct Task {
  size_t face;
  int block;
  double raysInCell;
  size_t occupants;  // 1 and the children of the tree's top that overlap it
};

std::vector<Task> planTasks(std::span<const LightBufferPoint> points, std::span<const PlannedFace> faces) {
  std::vector<Task> tasks;
  for (size_t p = 0; p < points.size(); ++p) {
    size_t occupied = 0;
    for (size_t f = 6 * p; f < 6 * p + 6; ++f)
      if (!faces[f].isEmpty()) occupied += occupiedCells(faces[f]);
    const double raysInCell = double(points[p].rays) / double(std::max<size_t>(1, occupied));
    for (size_t f = 6 * p; f < 6 * p + 6; ++f) {
      if (faces[f].isEmpty()) continue;
      const int blocks = faces[f].blocksOnASide() * faces[f].blocksOnASide();
      for (int block = 0; block < blocks; ++block) {
        const FaceRect rect = faces[f].blockRect(block);
        const std::vector<FaceRect>& rects = faces[f].occupied;
        const auto here =
            std::count_if(rects.begin(), rects.end(), [&](const FaceRect& r) { return r.overlaps(rect); });
        tasks.push_back({f, block, raysInCell, 1 + size_t(here)});
      }
    }
  }
  return tasks;
}

// Fills the blocks of all faces that are not empty, on all cores.
void buildBlocks(std::span<const LightBufferPoint> points, const LightBufferTree& tree, std::span<PlannedFace> faces) {
  const std::vector<Task> tasks = planTasks(points, faces);
  for (PlannedFace& face : faces)
    if (!face.isEmpty()) face.blocks.resize(size_t(face.blocksOnASide() * face.blocksOnASide()));
  size_t occupants = 0;
  for (const Task& task : tasks) occupants += task.occupants;
  parallelFor(tasks.size(), [&](size_t i) {
    const Task& task = tasks[i];
    PlannedFace& plan = faces[task.face];
    const CubeFace face(points[task.face / 6].position, int(task.face % 6));
    const CellBlockBounds bounds{std::min(kMostFineCellsInBlock, kMostFineCells / tasks.size()),
                                 kMostEntries / 2 / tasks.size() + kMostEntries / 2 * task.occupants / occupants};
    plan.blocks[size_t(task.block)] = buildCellBlock(tree, face, plan.blockRect(task.block),
                                                     plan.coarse / plan.blocksOnASide(), task.raysInCell, bounds);
  });
}

// LightBuffers::visitsNodes of each point.
std::vector<bool> findNodeVisits(std::span<const LightBufferPoint> points, std::span<const PlannedFace> faces) {
  std::vector<bool> visitsNodes(points.size());
  for (size_t p = 0; p < points.size(); ++p) {
    bool visits = false;
    for (size_t q = 0; q < points.size(); ++q) {
      if (points[q].kernelTraversal != points[p].kernelTraversal) continue;
      visits |= points[q].traversalVisitsNodes;
      for (size_t f = 6 * q; f < 6 * q + 6; ++f)
        for (const CellBlock& block : faces[f].blocks) visits |= block.visitsNodes;
    }
    visitsNodes[p] = visits;
  }
  return visitsNodes;
}

// Where the rows begin: those of the faces at 0, then coarse cells, fine cells and entries, two to a row.
struct LightBufferLayout {
  size_t coarse;  // the first of them is that of all empty faces
  size_t fine;    // the first of them is an empty list
  size_t entries;
  size_t entryCount = 0;

  explicit LightBufferLayout(std::span<const PlannedFace> faces) : coarse(faces.size()), fine(coarse + 1), entries(0) {
    for (const PlannedFace& face : faces) fine += face.blocks.empty() ? 0 : size_t(face.coarse * face.coarse);
    entries = fine + 1;
    for (const PlannedFace& face : faces) {
      for (const CellBlock& block : face.blocks) {
        entries += block.lists.size();
        entryCount += block.entries.size();
      }
    }
  }

  // Frees the blocks one by one. Lists of points whose rays visit no nodes are sorted by type.
  std::vector<Word4> write(std::span<PlannedFace> faces, const std::vector<bool>& visitsNodes) const;
};

std::vector<Word4> LightBufferLayout::write(std::span<PlannedFace> faces, const std::vector<bool>& visitsNodes) const {
  std::vector<Word4> rows;
  reservePrefaulted(rows, entries + entryCount / 2 + 2);
  rows.resize(entries);
  rows[coarse] = Word4{uint(fine), 1};
  rows[fine] = Word4{0, 0};
  size_t firstCell = coarse + 1, nextList = fine + 1;
  std::vector<CellListEntry> all;
  reservePrefaulted(all, entryCount);
  for (size_t f = 0; f < faces.size(); ++f) {
    PlannedFace& face = faces[f];
    if (face.blocks.empty()) {
      rows[f] = faceWord({}, 1, coarse);
      continue;
    }
    rows[f] = faceWord(face.window, face.coarse, firstCell);
    const int across = face.blocksOnASide(), side = face.coarse / across;
    for (size_t b = 0; b < face.blocks.size(); ++b) {
      CellBlock& block = face.blocks[b];
      const uint first = uint(2 * entries + all.size());
      size_t list = 0;
      for (size_t cell = 0; cell < block.levels.size(); ++cell) {
        const size_t x = b % size_t(across) * size_t(side) + cell % size_t(side);
        const size_t y = b / size_t(across) * size_t(side) + cell / size_t(side);
        rows[firstCell + y * size_t(face.coarse) + x] = Word4{uint(nextList), 1u << block.levels[cell]};
        for (size_t end = list + (size_t(1) << (2 * block.levels[cell])); list < end; ++list) {
          const CellList& l = block.lists[list];
          const auto begin = block.entries.begin();
          auto cones = begin + l.first, pairs = cones;
          if (!visitsNodes[f / 6]) {
            const auto isPair = [](const CellListEntry& e) { return (e.reference & gpu::kRefTriangle) != 0; };
            const auto isCone = [](const CellListEntry& e) { return (e.reference & gpu::kRefCone) != 0; };
            pairs = std::stable_partition(begin + l.first, begin + l.end, std::not_fn(isPair));
            cones = std::stable_partition(begin + l.first, pairs, std::not_fn(isCone));
          }
          rows[nextList++] = std::bit_cast<Word4>(
              gpu::FineCell{first + l.first, first + l.end, first + uint(pairs - begin), first + uint(cones - begin)});
        }
      }
      all.insert(all.end(), block.entries.begin(), block.entries.end());
      block = {};  // memory for the rows
    }
    firstCell += size_t(face.coarse * face.coarse);
  }
  for (size_t i = 0; i < all.size(); i += 2) {
    const CellListEntry a = all[i], b = i + 1 < all.size() ? all[i + 1] : CellListEntry{gpu::kRefNone, 0};
    rows.push_back({a.reference, std::bit_cast<uint>(a.distance), b.reference, std::bit_cast<uint>(b.distance)});
  }
  rows.push_back({});  // the kernel may look at the entry behind the last one
  return rows;
}

}  // namespace

LightBuffers buildLightBuffers(std::span<const LightBufferPoint> points, const LightBufferTree& tree) {
  std::vector<PlannedFace> faces = planFaces(points, tree.bvh);
  buildBlocks(points, tree, faces);
  LightBuffers lightBuffers;
  lightBuffers.visitsNodes = findNodeVisits(points, faces);
  lightBuffers.rows = LightBufferLayout(faces).write(faces, lightBuffers.visitsNodes);
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
  lightBuffers.rows.push_back(std::bit_cast<Word4>(gpu::FineCell{list, list + uint(all.size()), list, list}));
  for (size_t i = 0; i < all.size(); i += 2)
    lightBuffers.rows.push_back(Word4{all[i], 0, i + 1 < all.size() ? all[i + 1] : gpu::kRefNone, 0});
  lightBuffers.rows.push_back({});  // the kernel may look at the entry behind the last one
  return lightBuffers;
}

}  // namespace turner
