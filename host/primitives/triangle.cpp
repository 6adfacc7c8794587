// Planes are computed in double, of the rounded vertices.
#include "primitives/triangle.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "primitives/features.h"
#include "primitives/words.h"

namespace turner {
namespace {

struct Plane {
  glm::dvec3 normal;  // unit, on the counter-clockwise side
  double offset;      // N.x of its points
};

// Nothing where the triangle has no area. The same for all orders of the same vertices but for the sign: coincident
// triangles are hit at equal distances then, and the lowest id wins.
std::optional<Plane> planeOf(TriangleCorners v) {
  const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  double sign = 1;
  for (const auto& [i, j] : {std::pair<size_t, size_t>{0, 1}, {1, 2}, {0, 1}}) {
    if (!less(v[j], v[i])) continue;
    std::swap(v[i], v[j]);
    sign = -sign;
  }
  const glm::dvec3 cross = glm::cross(v[1] - v[0], v[2] - v[0]);
  const double length = glm::length(cross);
  if (length == 0) return {};
  const glm::dvec3 normal = cross / length;
  return Plane{sign * normal, sign * glm::dot(normal, v[0])};
}

// A triangle that rounding has made flat has no plane: it is seen edge-on by every ray and never hit.
gpu::Plane packPlane(const TriangleCorners& corners) {
  const std::optional<Plane> plane = planeOf(corners);
  return plane ? gpu::Plane{toVec3(plane->normal), float(plane->offset)} : gpu::Plane{};
}

}  // namespace

Bounds boundsOf(const TriangleCorners& corners) {
  const auto& [a, b, c] = corners;
  return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
}

bool isWithinReach(const TriangleCorners& local) {
  return std::all_of(local.begin(), local.end(),
                     [](const glm::dvec3& position) { return isWithin(position, kMostLocal); });
}

void addFeatures(const Triangle& local, Features& features) {
  features.triangles = true;
  features.smoothNormals |= local.isSmooth();
}

gpu::TrianglePair packPair(const TriangleCorners& first, uint32_t firstRank, const TriangleCorners* second,
                           uint32_t secondRank, uint32_t material, uint32_t normals) {
  const auto& [a, b, c] = first;
  gpu::TrianglePair packed{.v0 = toVec3(a),
                           .rank0 = firstRank,
                           .v1 = toVec3(b),
                           .material = material,
                           .v2 = toVec3(c),
                           .normals = normals,
                           .v3 = toVec3(b),
                           .rank1 = gpu::kRefNone,
                           .planes = {packPlane(first), {}}};
  if (second) {
    packed.v3 = toVec3((*second)[0]);
    packed.rank1 = secondRank;
    packed.planes[1] = packPlane(*second);
  }
  return packed;
}

}  // namespace turner
