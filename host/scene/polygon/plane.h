// Points of the plane and the one question that decides every cut: on which side of a line a point lies. Exact.
#pragma once

#include <compare>

namespace turner {

struct PlanePoint {
  double x, y;
  auto operator<=>(const PlanePoint&) const = default;
};

// The side of c seen from the line through a and b: 1 left, -1 right, 0 exactly on it. Exact unless products of the
// coordinates underflow or overflow.
int orientation(PlanePoint a, PlanePoint b, PlanePoint c);

}  // namespace turner
