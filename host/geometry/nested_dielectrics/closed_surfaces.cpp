// Welds vertices, joins triangles at their edges, and cuts what hangs together wherever no edge is left open.
#include "geometry/nested_dielectrics/closed_surfaces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace turner::nested_dielectrics {
namespace {

// Welds vertices: points nearer to each other than a few roundings of float32 get the same number, in whatever way
// their coordinates were computed or rounded.
class VertexWelder {
 public:
  uint32_t numberOf(const dvec3& p) {
    // The tolerance goes with the distance from the origin, by powers of two. Most points look into one cell of 16
    // tolerances on a side.
    const int level = levelOf(p, 1 - 1e-5), lastLevel = levelOf(p, 1 + 1e-5);
    for (int l = level; l <= lastLevel; ++l) {
      const double tolerance = toleranceAt(l);
      const Cell lo = cellOf(p - tolerance, l), hi = cellOf(p + tolerance, l);
      for (int64_t x = lo[0]; x <= hi[0]; ++x)
        for (int64_t y = lo[1]; y <= hi[1]; ++y)
          for (int64_t z = lo[2]; z <= hi[2]; ++z) {
            const auto [first, last] = vertices_.equal_range({x, y, z, l});
            for (auto it = first; it != last; ++it)
              if (glm::length(it->second.point - p) <= tolerance) return it->second.number;
          }
    }
    const uint32_t number = uint32_t(vertices_.size());
    vertices_.insert({cellOf(p, levelOf(p, 1)), {p, number}});
    return number;
  }

 private:
  using Cell = std::array<int64_t, 4>;  // and the level
  struct Numbered {
    dvec3 point;
    uint32_t number;
  };
  struct CellHash {
    size_t operator()(const Cell& c) const {
      const auto spread = [](int64_t i, uint64_t by) { return uint64_t(i) * by; };
      return (spread(c[0], 0x9e3779b97f4a7c15u) ^ std::rotl(spread(c[1], 0xc2b2ae3d27d4eb4fu), 21)) +
             spread(c[2], 0x165667b19e3779f9u) + uint64_t(c[3]);
    }
  };
  static int levelOf(const dvec3& p, double factor) {
    const double size = factor * std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    return size > 0 ? std::ilogb(size) : -1000;
  }
  static double toleranceAt(int level) { return std::ldexp(1.0, level - 20); }
  static Cell cellOf(const dvec3& p, int level) {
    const dvec3 cell = glm::floor(p / (16 * toleranceAt(level)));
    return {int64_t(cell.x), int64_t(cell.y), int64_t(cell.z), level};
  }

  std::unordered_multimap<Cell, Numbered, CellHash> vertices_;
};

// Sets the numbers, by position, of the vertices of these triangles: equal where they are welded. Each position is
// welded once, however many triangles share it.
void numberVertices(const Scene& scene, const std::vector<uint32_t>& triangles, std::vector<uint32_t>& numbers) {
  constexpr uint32_t kNone = UINT32_MAX;
  for (const uint32_t i : triangles)
    for (const uint32_t position : scene.triangles[i].positions) numbers[position] = kNone;
  VertexWelder welder;
  for (const uint32_t i : triangles)
    for (const uint32_t position : scene.triangles[i].positions)
      if (numbers[position] == kNone) numbers[position] = welder.numberOf(scene.positions[position] - scene.camera.eye);
}

// Sets that grow together.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0u); }
  uint32_t find(uint32_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void join(uint32_t a, uint32_t b) { parents_[find(a)] = find(b); }

 private:
  std::vector<uint32_t> parents_;
};

void measure(const Scene& scene, Surface& surface) {
  const dvec3 origin = scene.cornersOf(surface.triangles[0])[0];
  for (const uint32_t i : surface.triangles) {
    const auto [a, b, c] = scene.cornersOf(i);
    surface.volume += facing(scene, scene.triangles[i]) * glm::dot(a - origin, glm::cross(b - origin, c - origin)) / 6;
    surface.box.include(boundsFromEye(scene, scene.triangles[i]));
  }
}

// Adds the closed surfaces that triangles of one material make. Those that hang together by edges are gone through in
// their order: whenever no edge is left open, a surface is complete. So two cubes in a row that share an edge or a face
// are two. `numbers` has room for one of each position.
void addClosedSurfaces(const Scene& scene, const std::vector<uint32_t>& triangles, std::vector<uint32_t>& numbers,
                       std::vector<Surface>& surfaces) {
  numberVertices(scene, triangles, numbers);
  using Edge = std::pair<uint32_t, uint32_t>;
  std::vector<std::array<Edge, 3>> edges;
  for (const uint32_t i : triangles) {
    auto [a, b, c] = scene.triangles[i].positions;
    if (facing(scene, scene.triangles[i]) < 0) std::swap(b, c);
    const uint32_t p = numbers[a], q = numbers[b], r = numbers[c];
    edges.push_back({Edge{p, q}, {q, r}, {r, p}});
  }
  const auto keyOf = [](uint32_t a, uint32_t b) { return uint64_t(std::min(a, b)) << 32 | std::max(a, b); };
  std::unordered_map<uint64_t, uint32_t> neighbours;
  DisjointSets parts(triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i)
    for (const auto& [a, b] : edges[i]) parts.join(i, neighbours.try_emplace(keyOf(a, b), i).first->second);

  std::vector<uint32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  std::vector<uint32_t> partOf(triangles.size());
  for (uint32_t i = 0; i < triangles.size(); ++i) partOf[i] = parts.find(i);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return partOf[a] < partOf[b]; });

  using Open = std::unordered_map<uint64_t, int>;
  Open open;  // edges, by how often one direction is met more than the other
  Surface surface;
  for (size_t k = 0; k < order.size(); ++k) {
    if (k == 0 || partOf[order[k]] != partOf[order[k - 1]]) open = Open(), surface.triangles.clear();
    surface.triangles.push_back(triangles[order[k]]);
    for (const auto& [a, b] : edges[order[k]]) {
      if (a == b) continue;
      const auto entry = open.try_emplace(keyOf(a, b), 0).first;
      entry->second += a < b ? 1 : -1;
      if (entry->second == 0) open.erase(entry);
    }
    if (!open.empty()) continue;
    surface.material = scene.triangles[triangles[order[k]]].material;
    surface.firstId = uint32_t(scene.spheres.size()) + surface.triangles[0];
    surface.volume = 0;
    surface.box = {};
    measure(scene, surface);
    if (surface.volume != 0) surfaces.push_back(surface);
    surface.triangles.clear();
  }
}

}  // namespace

std::vector<Surface> closedSurfaces(const Scene& scene) {
  const auto transmits = [&](uint32_t material) { return scene.materials[material].transmit > 0; };
  std::vector<Surface> surfaces;
  if (!hasGlass(scene)) return surfaces;
  for (uint32_t i = 0; i < scene.spheres.size(); ++i) {
    const Sphere& sphere = scene.spheres[i];
    if (!transmits(sphere.material)) continue;
    const double radius = sphere.radius;
    surfaces.push_back({.material = sphere.material,
                        .firstId = i,
                        .sphere = i,
                        .volume = 4 * std::numbers::pi / 3 * radius * radius * radius,
                        .box = boundsFromEye(scene, sphere)});
  }
  std::vector<std::vector<uint32_t>> byMaterial(scene.materials.size());
  for (uint32_t i = 0; i < scene.triangles.size(); ++i)
    if (transmits(scene.triangles[i].material)) byMaterial[scene.triangles[i].material].push_back(i);
  std::vector<uint32_t> numbers(scene.positions.size());
  for (const std::vector<uint32_t>& triangles : byMaterial)
    if (!triangles.empty()) addClosedSurfaces(scene, triangles, numbers, surfaces);
  return surfaces;
}

}  // namespace turner::nested_dielectrics
