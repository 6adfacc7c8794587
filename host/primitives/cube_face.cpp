// Intervals for boxes; for pairs of triangles the lines through their outer edges.
#include "primitives/cube_face.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace turner {
namespace {

struct Interval {
  double lo, hi;
};

// The quotients of two intervals, of the divisor only what is above 0; unbounded ones are cut at kFar, off the face.
Interval quotient(const Interval& a, const Interval& c) {
  constexpr double kFar = 4;
  const double least = std::max(c.lo, 1e-30);
  const double lo = a.lo / (a.lo < 0 ? least : c.hi), hi = a.hi / (a.hi > 0 ? least : c.hi);
  return {std::clamp(lo, -kFar, kFar), std::clamp(hi, -kFar, kFar)};
}

}  // namespace

bool CubeFace::project(const Box& box, Projection& out) const {
  const auto along = [&](int axis) { return Interval{box.lo[axis] - point_[axis], box.hi[axis] - point_[axis]}; };
  Interval c = along(axis_), a = along((axis_ + 1) % 3), b = along((axis_ + 2) % 3);
  if (negative_) c = {-c.hi, -c.lo}, a = {-a.hi, -a.lo}, b = {-b.hi, -b.lo};
  if (!(c.hi > 0)) return false;
  const Interval u = quotient(a, c), v = quotient(b, c);
  out.rect = {float(u.lo), float(u.hi), float(v.lo), float(v.hi)};
  out.distance = c.lo > 0 ? float(c.lo * (1 - 0x1p-20)) : 0.0f;
  return true;
}

void CubeFace::projectEdges(const Corners& corners, const Box& box, OuterEdges& edges) const {
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
  // The corners may be off by as much as the box is padded, the largest pad on any axis; seen from the point in u, v:
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

}  // namespace turner
