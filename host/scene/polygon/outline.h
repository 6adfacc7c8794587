// Outlines of polygons, projected into a plane. Both kinds say of three of their points how they turn, exactly.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "scene/polygon/plane.h"

namespace turner {

using Triangle3 = std::array<uint32_t, 3>;

// Projected along an axis: the points are the corners' own numbers.
struct FlatOutline {
  static constexpr double kRounding = 0;  // of the points
  std::vector<PlanePoint> points;
  std::vector<uint32_t> corners;  // that the points are, as indices into the polygon

  size_t size() const { return points.size(); }
  int orientation(uint32_t a, uint32_t b, uint32_t c) const {
    return turner::orientation(points[a], points[b], points[c]);
  }
};

// Projected along the polygon's normal, about which it winds to the left: its points are rounded, its turns are not.
struct TiltedOutline {
  static constexpr double kRounding = 1e-14;  // of the points, whose size is about 1
  std::vector<PlanePoint> points;
  std::vector<uint32_t> corners;
  std::vector<glm::dvec3> places;  // of the corners
  glm::dvec3 normal{0};

  size_t size() const { return points.size(); }
  int orientation(uint32_t a, uint32_t b, uint32_t c) const {
    return turner::orientation(normal, places[a], places[b], places[c]);
  }
};

template <class Outline>
uint32_t pointAfter(const Outline& outline, uint32_t i) {
  return i + 1 == outline.size() ? 0 : i + 1;
}
template <class Outline>
uint32_t pointBefore(const Outline& outline, uint32_t i) {
  return (i == 0 ? uint32_t(outline.size()) : i) - 1;
}
// 1 where the outline turns left, -1 right, 0 where it runs straight on or back.
template <class Outline>
int turnAt(const Outline& outline, uint32_t i) {
  return outline.orientation(pointBefore(outline, i), i, pointAfter(outline, i));
}

// Twice the signed area; long double, as it is compared with sums of other roundings.
template <class Points>
long double twiceArea(const Points& points) {
  long double sum = 0;
  for (size_t i = 1; i + 1 < points.size(); ++i) {
    const long double ax = (long double)points[i].x - points[0].x, ay = (long double)points[i].y - points[0].y;
    const long double bx = (long double)points[i + 1].x - points[0].x, by = (long double)points[i + 1].y - points[0].y;
    sum += ax * by - ay * bx;
  }
  return sum;
}

}  // namespace turner
