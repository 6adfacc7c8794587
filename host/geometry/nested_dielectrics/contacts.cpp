// Tests of pairs of primitives, by a tree of their bounds.
#include "geometry/nested_dielectrics/contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "geometry/nested_dielectrics/bounds_tree.h"

namespace turner::nested_dielectrics {
namespace {

// The distance of a point from a triangle: of its projection if that is inside, else of the nearest edge.
double distanceTo(const TriangleCorners& v, const dvec3& p) {
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
  const TriangleCorners a = scene.cornersOf(s), b = scene.cornersOf(t);
  const double slack = kTouching * std::max(sizeOf(boundsFromEye(scene, s)), sizeOf(boundsFromEye(scene, t)));
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
  const auto edge = [](const TriangleCorners& v, size_t k) { return v[(k + 1) % 3] - v[k]; };
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

bool meet(const Scene& scene, const BoundsTree::Item& a, const BoundsTree::Item& b) {
  const size_t spheres = scene.spheres.size();
  if (a.index >= spheres && b.index < spheres) return meet(scene, b, a);
  if (a.index >= spheres) return meet(scene, scene.triangles[a.index - spheres], scene.triangles[b.index - spheres]);
  const Sphere& sphere = scene.spheres[a.index];
  const double radius = std::abs(sphere.radius);
  if (b.index >= spheres) return distanceTo(scene.cornersOf(b.index - spheres), sphere.center) < kKissing * radius;
  const Sphere& other = scene.spheres[b.index];
  return glm::length(other.center - sphere.center) < kKissing * (radius + std::abs(other.radius));
}

// Whether two triangles lie in the same plane of equal x, y or z: the kernel meets both at exactly the same distance.
bool shareAxialPlane(const TriangleCorners& s, const TriangleCorners& t) {
  for (int k = 0; k < 3; ++k) {
    const double plane = s[0][k];
    const auto isIn = [&](const dvec3& p) { return p[k] == plane; };
    if (std::all_of(s.begin(), s.end(), isIn) && std::all_of(t.begin(), t.end(), isIn)) return true;
  }
  return false;
}

// Whether two primitives that meet are in one place and not only across each other, coplanar triangles or equal
// spheres, while rounding may tell them apart.
bool coincide(const Scene& scene, const BoundsTree::Item& a, const BoundsTree::Item& b) {
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
  const Triangle &first = scene.triangles[a.index - spheres], &second = scene.triangles[b.index - spheres];
  const TriangleCorners s = scene.cornersOf(first), t = scene.cornersOf(second);
  if (shareAxialPlane(s, t)) return false;
  const auto inPlaneOf = [&](const TriangleCorners& v, const TriangleCorners& other) {
    const dvec3 normal = glm::cross(v[1] - v[0], v[2] - v[0]);
    const double most = slack * glm::length(normal);
    return most > 0 && std::all_of(other.begin(), other.end(),
                                   [&](const dvec3& p) { return std::abs(glm::dot(p - v[0], normal)) <= most; });
  };
  return (inPlaneOf(s, t) || inPlaneOf(t, s)) && meet(scene, first, second);
}

}  // namespace

// Of each solid whether an interface of another meets one of its own, or the bounds of a mesh hold those of another
// solid. It is enough that every solid looks for one partner and for one mesh around it: that one looks for what is
// around it, too.
void markMeeting(const Scene& scene, const std::vector<Solid>& solids, std::vector<bool>& marked) {
  if (solids.size() < 2) return;
  std::vector<BoundsTree::Item> interfaces, meshes;
  for (uint32_t k = 0; k < solids.size(); ++k) {
    const Surface& outer = solids[k].outer();
    if (outer.sphere == kNoMedium) meshes.push_back({.box = outer.box, .owner = k, .index = 0, .volume = outer.volume});
    forPrimitives(scene, solids[k],
                  [&](uint32_t id, const Bounds& box) { interfaces.push_back({.box = box, .owner = k, .index = id}); });
  }
  const BoundsTree tree(interfaces), meshTree(std::move(meshes));
  for (uint32_t k = 0; k < solids.size(); ++k) {
    const BoundsTree::Item* const around = meshTree.smallestHolding(
        solids[k].outer().box, 0, [&](const BoundsTree::Item& mesh) { return mesh.owner != k; });
    if (around) marked[k] = marked[around->owner] = true;
  }
  for (const BoundsTree::Item& item : interfaces) {
    if (marked[item.owner]) continue;
    tree.findMeeting(item.box, item.owner, [&](const BoundsTree::Item& other) {
      if (!meet(scene, item, other)) return false;
      marked[item.owner] = marked[other.owner] = true;
      return true;
    });
  }
}

void markOnOpaque(const Scene& scene, const std::vector<Solid>& solids, std::vector<bool>& marked) {
  std::vector<BoundsTree::Item> interfaces;
  for (uint32_t k = 0; k < solids.size(); ++k)
    if (!marked[k])
      forPrimitives(scene, solids[k], [&](uint32_t id, const Bounds& box) {
        interfaces.push_back({.box = box, .owner = k, .index = id});
      });
  if (interfaces.empty()) return;
  const BoundsTree tree(std::move(interfaces));
  const auto look = [&](const auto& primitive, size_t id) {
    if (scene.materials[primitive.material].transmit > 0) return;
    const BoundsTree::Item item{.box = boundsFromEye(scene, primitive), .owner = kNoMedium, .index = uint32_t(id)};
    tree.findMeeting(item.box, kNoMedium, [&](const BoundsTree::Item& other) {
      if (!marked[other.owner] && coincide(scene, item, other)) marked[other.owner] = true;
      return false;
    });
  };
  for (size_t i = 0; i < scene.spheres.size(); ++i) look(scene.spheres[i], i);
  for (size_t i = 0; i < scene.triangles.size(); ++i) look(scene.triangles[i], scene.spheres.size() + i);
}

}  // namespace turner::nested_dielectrics
