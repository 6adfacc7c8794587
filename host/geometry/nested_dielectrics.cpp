// Finds closed surfaces, then pairs of them that meet, by a tree of boxes.
#include "geometry/nested_dielectrics.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <unordered_map>
#include <utility>

namespace turner {

bool hasGlass(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.transmit > 0; });
}

double facing(const Scene& scene, const Triangle& triangle) {
  if (triangle.normals == kNoNormals) return 1;
  const auto& [a, b, c] = triangle.vertices;
  const auto& n = scene.normals[triangle.normals];
  return glm::dot(glm::cross(b - a, c - a), n[0] + n[1] + n[2]) < 0 ? -1 : 1;
}

namespace {

using glm::dvec3;
using wide3 = glm::tvec3<long double, glm::defaultp>;

struct Bounds {
  dvec3 lo{std::numeric_limits<double>::infinity()}, hi{-std::numeric_limits<double>::infinity()};
  void include(const Bounds& other) {
    lo = glm::min(lo, other.lo);
    hi = glm::max(hi, other.hi);
  }
};

// Seen from the eye, as are all bounds here: float32 rounds what the kernel gets in proportion to that.
Bounds boundsOf(const Scene& scene, const Sphere& sphere) {
  const dvec3 center = sphere.center - scene.camera.eye;
  const double radius = std::abs(sphere.radius);
  return {center - radius, center + radius};
}
Bounds boundsOf(const Scene& scene, const Triangle& triangle) {
  const auto& [a, b, c] = triangle.vertices;
  return {glm::min(a, glm::min(b, c)) - scene.camera.eye, glm::max(a, glm::max(b, c)) - scene.camera.eye};
}

// Walls nearer to each other than this share of their distance from the eye touch. More than what the renderers take
// for one place; what touches without need costs time, and no more.
constexpr double kTouching = 1e-5;

double sizeOf(const Bounds& box) {
  const dvec3 size = glm::max(glm::abs(box.lo), glm::abs(box.hi));
  return std::max({size.x, size.y, size.z});
}

bool meet(const Bounds& a, const Bounds& b) {
  const double slack = kTouching * std::max(sizeOf(a), sizeOf(b));
  return glm::all(glm::lessThanEqual(a.lo, b.hi + slack)) && glm::all(glm::lessThanEqual(b.lo, a.hi + slack));
}

bool holds(const Bounds& outer, const Bounds& inner) {
  const double slack = kTouching * sizeOf(outer);
  return glm::all(glm::lessThanEqual(outer.lo - slack, inner.lo)) &&
         glm::all(glm::lessThanEqual(inner.hi, outer.hi + slack));
}

// ---- Closed surfaces ----

// A sphere, or triangles.
struct Surface {
  uint32_t material;
  uint32_t firstId;  // least id of its primitives
  uint32_t sphere = kNoMedium;
  std::vector<uint32_t> triangles;
  double volume = 0;  // negative: it faces inward
  Bounds box;
};

// Numbers points: those nearer to each other than a few roundings of float32 have the same number, in whatever way
// their coordinates were computed or rounded.
class PointNumbers {
 public:
  uint32_t of(const dvec3& p) {
    // The tolerance goes with the distance from the origin, by powers of two. Most points look into one cell of 16
    // tolerances on a side.
    const int level = levelOf(p, 1 - 1e-5), lastLevel = levelOf(p, 1 + 1e-5);
    for (int l = level; l <= lastLevel; ++l) {
      const double tolerance = toleranceAt(l);
      const Cell lo = cellOf(p - tolerance, l), hi = cellOf(p + tolerance, l);
      for (int64_t x = lo[0]; x <= hi[0]; ++x)
        for (int64_t y = lo[1]; y <= hi[1]; ++y)
          for (int64_t z = lo[2]; z <= hi[2]; ++z) {
            const auto [first, last] = numbers_.equal_range({x, y, z, l});
            for (auto it = first; it != last; ++it)
              if (glm::length(it->second.point - p) <= tolerance) return it->second.number;
          }
    }
    const uint32_t number = uint32_t(numbers_.size());
    numbers_.insert({cellOf(p, levelOf(p, 1)), {p, number}});
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

  std::unordered_multimap<Cell, Numbered, CellHash> numbers_;
};

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
  const dvec3 origin = scene.triangles[surface.triangles[0]].vertices[0];
  for (const uint32_t i : surface.triangles) {
    const auto& [a, b, c] = scene.triangles[i].vertices;
    surface.volume += facing(scene, scene.triangles[i]) * glm::dot(a - origin, glm::cross(b - origin, c - origin)) / 6;
    surface.box.include(boundsOf(scene, scene.triangles[i]));
  }
}

// Adds the closed surfaces that triangles of one material make. Those that hang together by edges are gone through in
// their order: whenever no edge is left open, a surface is complete. So two cubes in a row that share an edge or a face
// are two.
void addClosedSurfaces(const Scene& scene, const std::vector<uint32_t>& triangles, std::vector<Surface>& surfaces) {
  PointNumbers numbers;
  using Edge = std::pair<uint32_t, uint32_t>;
  std::vector<std::array<Edge, 3>> edges;
  for (const uint32_t i : triangles) {
    auto [a, b, c] = scene.triangles[i].vertices;
    if (facing(scene, scene.triangles[i]) < 0) std::swap(b, c);
    const dvec3& eye = scene.camera.eye;
    const uint32_t p = numbers.of(a - eye), q = numbers.of(b - eye), r = numbers.of(c - eye);
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
                        .box = boundsOf(scene, sphere)});
  }
  std::vector<std::vector<uint32_t>> byMaterial(scene.materials.size());
  for (uint32_t i = 0; i < scene.triangles.size(); ++i)
    if (transmits(scene.triangles[i].material)) byMaterial[scene.triangles[i].material].push_back(i);
  for (const std::vector<uint32_t>& triangles : byMaterial)
    if (!triangles.empty()) addClosedSurfaces(scene, triangles, surfaces);
  return surfaces;
}

// ---- NestedDielectrics ----

struct Solid {
  std::vector<const Surface*> surfaces;  // the outer one, then those of its hollows
  const Surface& outer() const { return *surfaces[0]; }
};

// A tree over boxes, halved at the median of the longest side.
class BoxTree {
 public:
  struct Item {
    Bounds box;
    uint32_t owner, index;
    double volume = 0;
  };

  explicit BoxTree(std::vector<Item> items) : items_(std::move(items)) {
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

// Solids and the hollows in them; a hollow in no solid of its material is none of anything.
std::vector<Solid> solidsOf(const std::vector<Surface>& surfaces) {
  std::vector<Solid> dielectrics;
  std::vector<BoxTree::Item> items;
  for (const Surface& surface : surfaces) {
    if (surface.volume < 0) continue;
    items.push_back({surface.box, uint32_t(dielectrics.size()), 0, surface.volume});
    dielectrics.push_back({{&surface}});
  }
  const BoxTree tree(std::move(items));
  for (const Surface& surface : surfaces) {
    if (surface.volume > 0) continue;
    const BoxTree::Item* const smallest = tree.smallestHolding(
        surface.box, -surface.volume,
        [&](const BoxTree::Item& item) { return dielectrics[item.owner].outer().material == surface.material; });
    if (smallest) dielectrics[smallest->owner].surfaces.push_back(&surface);
  }
  return dielectrics;
}

// ---- Which of them meet ----

// The distance of a point from a triangle: of its projection if that is inside, else of the nearest edge.
double distanceTo(const Triangle& triangle, const dvec3& p) {
  const auto& v = triangle.vertices;
  const dvec3 normal = glm::cross(v[1] - v[0], v[2] - v[0]);
  const double squared = glm::dot(normal, normal);
  bool inside = squared > 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const dvec3 &a = v[size_t(k)], edge = v[size_t((k + 1) % 3)] - a, toPoint = p - a;
    if (glm::dot(glm::cross(edge, toPoint), normal) < 0) inside = false;
    const double length2 = glm::dot(edge, edge);
    const double along = length2 > 0 ? std::clamp(glm::dot(toPoint, edge) / length2, 0.0, 1.0) : 0;
    nearest = std::min(nearest, glm::length(toPoint - along * edge));
  }
  return inside ? std::abs(glm::dot(p - v[0], normal)) / std::sqrt(squared) : nearest;
}

// Whether two triangles meet: no axis separates them (Gottschalk, Lin and Manocha, OBBTree, SIGGRAPH 1996, section 5,
// for triangles: their normals, products of edges, and where they are coplanar the edges' normals in the plane).
bool meet(const Scene& scene, const Triangle& s, const Triangle& t) {
  const auto &a = s.vertices, &b = t.vertices;
  const double slack = kTouching * std::max(sizeOf(boundsOf(scene, s)), sizeOf(boundsOf(scene, t)));
  const auto separates = [&](const dvec3& axis) {
    const double length = glm::length(axis);
    if (!(length > 0)) return false;
    double aLo = std::numeric_limits<double>::infinity(), aHi = -aLo, bLo = aLo, bHi = aHi;
    for (size_t k = 0; k < 3; ++k) {
      const double onA = glm::dot(axis, a[k] - a[0]), onB = glm::dot(axis, b[k] - a[0]);
      aLo = std::min(aLo, onA), aHi = std::max(aHi, onA);
      bLo = std::min(bLo, onB), bHi = std::max(bHi, onB);
    }
    return std::max(bLo - aHi, aLo - bHi) > slack * length;
  };
  const auto edge = [](const std::array<dvec3, 3>& v, size_t k) { return v[(k + 1) % 3] - v[k]; };
  const dvec3 aNormal = glm::cross(edge(a, 0), edge(a, 1)), bNormal = glm::cross(edge(b, 0), edge(b, 1));
  if (separates(aNormal) || separates(bNormal)) return false;
  for (size_t i = 0; i < 3; ++i) {
    // An axis almost 0 says nothing: edges that are parallel but for their rounding.
    if (separates(glm::cross(aNormal, edge(a, i))) || separates(glm::cross(bNormal, edge(b, i)))) return false;
    for (size_t j = 0; j < 3; ++j) {
      const dvec3 p = edge(a, i), q = edge(b, j), axis = glm::cross(p, q);
      if (glm::length(axis) > 1e-9 * glm::length(p) * glm::length(q) && separates(axis)) return false;
    }
  }
  return true;
}

// Spheres that do no more than touch each other in a point are left to themselves: rays pass one after the other.
constexpr double kKissing = 1 - 1e-5;

bool meet(const Scene& scene, const BoxTree::Item& a, const BoxTree::Item& b) {
  const size_t spheres = scene.spheres.size();
  if (a.index >= spheres && b.index < spheres) return meet(scene, b, a);
  if (a.index >= spheres) return meet(scene, scene.triangles[a.index - spheres], scene.triangles[b.index - spheres]);
  const Sphere& sphere = scene.spheres[a.index];
  const double radius = std::abs(sphere.radius);
  if (b.index >= spheres) return distanceTo(scene.triangles[b.index - spheres], sphere.center) < kKissing * radius;
  const Sphere& other = scene.spheres[b.index];
  return glm::length(other.center - sphere.center) < kKissing * (radius + std::abs(other.radius));
}

template <class Visit>
void forPrimitives(const Scene& scene, const Solid& solid, Visit&& visit) {
  for (const Surface* surface : solid.surfaces) {
    if (surface->sphere != kNoMedium) visit(surface->sphere, boundsOf(scene, scene.spheres[surface->sphere]));
    for (const uint32_t i : surface->triangles)
      visit(uint32_t(scene.spheres.size()) + i, boundsOf(scene, scene.triangles[i]));
  }
}

// Of each solid whether a wall of another meets one of its own, or the bounds of a mesh hold those of another solid. It
// is enough that every solid looks for one partner and for one mesh around it: that one looks for what is around it,
// too.
void markMeeting(const Scene& scene, const std::vector<Solid>& dielectrics, std::vector<bool>& marked) {
  if (dielectrics.size() < 2) return;
  std::vector<BoxTree::Item> walls, meshes;
  for (uint32_t k = 0; k < dielectrics.size(); ++k) {
    const Surface& outer = dielectrics[k].outer();
    if (outer.sphere == kNoMedium) meshes.push_back({.box = outer.box, .owner = k, .index = 0, .volume = outer.volume});
    forPrimitives(scene, dielectrics[k],
                  [&](uint32_t id, const Bounds& box) { walls.push_back({.box = box, .owner = k, .index = id}); });
  }
  const BoxTree tree(walls), meshTree(std::move(meshes));
  for (uint32_t k = 0; k < dielectrics.size(); ++k) {
    const BoxTree::Item* const around = meshTree.smallestHolding(
        dielectrics[k].outer().box, 0, [&](const BoxTree::Item& mesh) { return mesh.owner != k; });
    if (around) marked[k] = marked[around->owner] = true;
  }
  for (const BoxTree::Item& item : walls) {
    if (marked[item.owner]) continue;
    tree.findMeeting(item.box, item.owner, [&](const BoxTree::Item& other) {
      if (!meet(scene, item, other)) return false;
      marked[item.owner] = marked[other.owner] = true;
      return true;
    });
  }
}

// Whether two triangles lie in the same plane of equal x, y or z: the kernel meets both at exactly the same distance.
bool shareAxialPlane(const Triangle& s, const Triangle& t) {
  for (int k = 0; k < 3; ++k) {
    const double plane = s.vertices[0][k];
    const auto isIn = [&](const dvec3& p) { return p[k] == plane; };
    if (std::all_of(s.vertices.begin(), s.vertices.end(), isIn) &&
        std::all_of(t.vertices.begin(), t.vertices.end(), isIn))
      return true;
  }
  return false;
}

// Whether two primitives that meet are in one place and not only across each other, coplanar triangles or equal
// spheres, while rounding may tell them apart.
bool coincide(const Scene& scene, const BoxTree::Item& a, const BoxTree::Item& b) {
  const size_t spheres = scene.spheres.size();
  if ((a.index < spheres) != (b.index < spheres)) return false;
  // Both are rounded: a rounding each, and half as much again as planes are tilted.
  constexpr double kRounded = 1.5 * 0x1p-23;
  if (a.index < spheres) {
    const Sphere &s = scene.spheres[a.index], &t = scene.spheres[b.index];
    const double sRadius = std::abs(s.radius), tRadius = std::abs(t.radius);
    if (s.center == t.center && sRadius == tRadius) return false;
    return glm::length(s.center - t.center) <= kRounded * glm::length(s.center - scene.camera.eye) &&
           std::abs(sRadius - tRadius) <= kRounded * sRadius;
  }
  const double slack = kRounded * std::max(sizeOf(a.box), sizeOf(b.box));
  const Triangle &s = scene.triangles[a.index - spheres], &t = scene.triangles[b.index - spheres];
  if (shareAxialPlane(s, t)) return false;
  const auto inPlaneOf = [&](const Triangle& plane, const Triangle& other) {
    const auto& v = plane.vertices;
    const dvec3 normal = glm::cross(v[1] - v[0], v[2] - v[0]);
    const double most = slack * glm::length(normal);
    return most > 0 && std::all_of(other.vertices.begin(), other.vertices.end(),
                                   [&](const dvec3& p) { return std::abs(glm::dot(p - v[0], normal)) <= most; });
  };
  return (inPlaneOf(s, t) || inPlaneOf(t, s)) && meet(scene, s, t);
}

// Of each solid whether something opaque lies in a face of its own.
void markOnOpaque(const Scene& scene, const std::vector<Solid>& dielectrics, std::vector<bool>& marked) {
  std::vector<BoxTree::Item> walls;
  for (uint32_t k = 0; k < dielectrics.size(); ++k)
    if (!marked[k])
      forPrimitives(scene, dielectrics[k],
                    [&](uint32_t id, const Bounds& box) { walls.push_back({.box = box, .owner = k, .index = id}); });
  if (walls.empty()) return;
  const BoxTree tree(std::move(walls));
  const auto look = [&](const auto& primitive, size_t id) {
    if (scene.materials[primitive.material].transmit > 0) return;
    const BoxTree::Item item{.box = boundsOf(scene, primitive), .owner = kNoMedium, .index = uint32_t(id)};
    tree.findMeeting(item.box, kNoMedium, [&](const BoxTree::Item& other) {
      if (!marked[other.owner] && coincide(scene, item, other)) marked[other.owner] = true;
      return false;
    });
  };
  for (size_t i = 0; i < scene.spheres.size(); ++i) look(scene.spheres[i], i);
  for (size_t i = 0; i < scene.triangles.size(); ++i) look(scene.triangles[i], scene.spheres.size() + i);
}

// ---- Which of them are around the eye ----

// How often a surface goes around a point: 1 or -1 inside, 0 outside.
double windingNumber(const Scene& scene, const Surface& surface, const dvec3& p) {
  if (surface.sphere != kNoMedium) {
    const Sphere& sphere = scene.spheres[surface.sphere];
    const long double radius = (long double)(sphere.radius) + sphere.radiusRest;
    const double sign = sphere.radius < 0 ? -1 : 1;
    return glm::length(wide3(p) - wide3(sphere.center)) < std::abs(radius) ? sign : 0;
  }
  // Solid angles: Van Oosterom and Strackee, IEEE Transactions on Biomedical Engineering 30(2), 1983.
  double angle = 0;
  for (const uint32_t i : surface.triangles) {
    const auto& v = scene.triangles[i].vertices;
    const dvec3 a = v[0] - p, b = v[1] - p, c = v[2] - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    angle += facing(scene, scene.triangles[i]) * 2 *
             std::atan2(glm::dot(a, glm::cross(b, c)),
                        la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

// What a material is but for its name, as float32 has it.
std::array<float, 11> valuesOf(const Material& m) {
  std::array<float, 11> values{};
  size_t i = 0;
  for (const double value : {m.diffuse.x, m.diffuse.y, m.diffuse.z, m.specular.x, m.specular.y, m.specular.z,
                             m.shininess, m.reflect, m.transmit, m.eta, m.localWeight})
    values[i++] = float(value);
  return values;
}

}  // namespace

NestedDielectrics findNestedDielectrics(const Scene& scene) {
  const std::vector<Surface> surfaces = closedSurfaces(scene);
  const std::vector<Solid> dielectrics = solidsOf(surfaces);
  std::vector<bool> marked(dielectrics.size());
  markMeeting(scene, dielectrics, marked);
  markOnOpaque(scene, dielectrics, marked);
  std::vector<uint32_t> order;
  for (uint32_t k = 0; k < dielectrics.size(); ++k)
    if (marked[k]) order.push_back(k);
  NestedDielectrics result;
  if (order.empty()) return result;

  // Volumes that differ by rounding are the same: the exact and the rounded scene are to agree.
  const auto volumeClass = [&](uint32_t k) { return std::lround(1024 * std::log2(dielectrics[k].outer().volume)); };
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    const long va = volumeClass(a), vb = volumeClass(b);
    return va != vb ? va > vb : dielectrics[a].outer().firstId < dielectrics[b].outer().firstId;
  });
  result.ofSpheres.assign(scene.spheres.size(), kNoMedium);
  result.ofTriangles.assign(scene.triangles.size(), kNoMedium);
  std::map<std::array<float, 11>, uint32_t> glasses;
  for (uint32_t rank = 0; rank < order.size(); ++rank) {
    const Solid& solid = dielectrics[order[rank]];
    result.materials.push_back(solid.outer().material);
    result.glasses.push_back(
        glasses.try_emplace(valuesOf(scene.materials[solid.outer().material]), uint32_t(glasses.size())).first->second);
    forPrimitives(scene, solid, [&](uint32_t id, const Bounds&) {
      if (id < scene.spheres.size())
        result.ofSpheres[id] = rank;
      else
        result.ofTriangles[id - scene.spheres.size()] = rank;
    });
    double winding = 0;
    for (const Surface* surface : solid.surfaces) winding += windingNumber(scene, *surface, scene.camera.eye);
    if (winding > 0.5) result.aroundEye.push_back(rank);
  }
  return result;
}

}  // namespace turner
