// Points of the plane and the one question that decides every cut: on which side of a line a point lies. Exact.
#pragma once

#include <compare>
#include <glm/vec3.hpp>

namespace turner {

struct PlanePoint {
  double x, y;
  auto operator<=>(const PlanePoint&) const = default;
};

// The side of c seen from the line through a and b: 1 left, -1 right, 0 exactly on it. Exact unless products of the
// coordinates underflow or overflow.
int orientation(PlanePoint a, PlanePoint b, PlanePoint c);

// The same for points of space projected along `normal`, which points at the viewer: the sign of
// normal . ((b - a) x (c - a)).
int orientation(const glm::dvec3& normal, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

}  // namespace turner
