// In: the corners of a polygon in space. Out: triangles over them. The polygon is projected along the axis to which its
// normal is closest, by dropping that coordinate: the points of the plane are then the input's own numbers. Where it is
// warped and that turns a triangle over or loses a corner, it is projected along the normal itself.
#include "scene/polygon/polygon.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "scene/polygon/outline.h"
#include "scene/polygon/simple_polygon.h"
#include "scene/polygon/touching_polygon.h"

namespace turner {

namespace {

using Corners = std::span<const glm::dvec3>;
using Triangles = std::vector<Triangle3>;

// How a polygon lies in space. A power of two brings its size to about 1: that is exact, and products of very small or
// large coordinates neither vanish nor overflow.
struct Plane {
  double scale;
  glm::dvec3 normal;  // of the corners times `scale`, twice the area long (Newell's method)
  int axis;           // to which the normal is closest

  PlanePoint flatten(const glm::dvec3& corner) const {
    return {scale * corner[(axis + 1) % 3], scale * corner[(axis + 2) % 3]};
  }
};

int largest(const glm::dvec3& v) {
  return v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2;
}

// At least one corner.
Plane planeOf(Corners corners) {
  double extent = 0;
  for (const glm::dvec3& corner : corners) {
    extent = std::max({extent, std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
  }
  const double scale = extent > 0 ? std::scalbn(1.0, std::clamp(-std::ilogb(extent), -1000, 1000)) : 1;
  glm::dvec3 normal(0), magnitude(0);
  const glm::dvec3 first = scale * corners[0];
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    const glm::dvec3 part = glm::cross(scale * corners[i] - first, scale * corners[i + 1] - first);
    normal += part;
    magnitude += glm::abs(part);
  }
  // Where the parts cancel (an outline like an 8), the sum is rounding noise and says nothing about the plane.
  const int axis = largest(glm::abs(normal));
  const bool cancels = !(std::abs(normal[axis]) > 1e-12 * magnitude[largest(magnitude)]);
  return {scale, cancels ? glm::dvec3(0) : normal, cancels ? largest(magnitude) : axis};
}

// Whether the corners lie in a plane but for what rounding to double has moved them, or on a line: then they have no
// normal.
bool isPlanar(Corners corners, const Plane& plane) {
  // Sizes are about 1, a double's step is 2e-16, and a height sums a few of them.
  const double twiceArea = std::abs(plane.normal.x) + std::abs(plane.normal.y) + std::abs(plane.normal.z);
  const double most = 4e-15 * twiceArea;
  double length = 0;
  bool hasHeight = false;
  for (const glm::dvec3& corner : corners) {
    const glm::dvec3 step = plane.scale * corner - plane.scale * corners[0];
    hasHeight |= std::abs(glm::dot(plane.normal, step)) > most;
    length = std::max({length, std::abs(step.x), std::abs(step.y), std::abs(step.z)});
  }
  return !hasHeight || twiceArea <= 1e-14 * double(corners.size()) * length;
}

// Without corners that are projected to the same point as the one before.
FlatOutline flatten(Corners corners, const Plane& plane) {
  FlatOutline outline;
  outline.points.reserve(corners.size());
  outline.corners.reserve(corners.size());
  for (uint32_t i = 0; i < corners.size(); ++i) {
    const PlanePoint point = plane.flatten(corners[i]);
    if (!outline.points.empty() && outline.points.back() == point) continue;
    outline.points.push_back(point);
    outline.corners.push_back(i);
  }
  while (outline.size() > 1 && outline.points.back() == outline.points.front()) {
    outline.points.pop_back();
    outline.corners.pop_back();
  }
  return outline;
}

// The corners that differ from the one before.
std::vector<uint32_t> distinctCorners(Corners corners) {
  std::vector<uint32_t> distinct;
  for (uint32_t i = 0; i < corners.size(); ++i) {
    if (distinct.empty() || corners[i] != corners[distinct.back()]) distinct.push_back(i);
  }
  while (distinct.size() > 1 && corners[distinct.back()] == corners[distinct.front()]) distinct.pop_back();
  return distinct;
}

TiltedOutline tilt(Corners corners, std::vector<uint32_t> distinct, const Plane& plane) {
  TiltedOutline outline;
  outline.corners = std::move(distinct);
  outline.normal = plane.normal;
  // Two axes across the normal, so that it points at who sees the first turn left into the second.
  const glm::dvec3 normal = glm::normalize(plane.normal);
  glm::dvec3 across(0);
  across[(plane.axis + 1) % 3] = 1;
  const glm::dvec3 second = glm::normalize(glm::cross(normal, across)), first = glm::cross(second, normal);
  for (const uint32_t corner : outline.corners) {
    const glm::dvec3 place = plane.scale * corners[corner];
    outline.places.push_back(place);
    outline.points.push_back({glm::dot(place, first), glm::dot(place, second)});
  }
  return outline;
}

// Whether a point runs to and fro along the outline just once: with turns to one side only, that is a convex polygon.
bool windsOnce(const std::vector<PlanePoint>& points) {
  int changes = 0;
  const size_t count = points.size();
  for (size_t i = 0; i < count; ++i) {
    const bool rises = points[i] < points[i + 1 == count ? 0 : i + 1];
    const bool roseBefore = points[(i == 0 ? count : i) - 1] < points[i];
    changes += rises != roseBefore;
  }
  return changes == 2;
}

// The fan from point 0, or nothing where a fan is not right: the polygon is not convex, or a straight corner beside
// point 0 would be left out of all triangles, so that a neighbour that uses it would leave a crack.
template <class Outline>
Triangles fan(const Outline& outline) {
  int side = 0;
  for (uint32_t i = 0; i < outline.size(); ++i) {
    const int turn = turnAt(outline, i);
    if (turn * side < 0) return {};
    if (turn != 0) side = turn;
  }
  if (side == 0 || !windsOnce(outline.points)) return {};
  Triangles triangles;
  triangles.reserve(outline.size() - 2);
  for (uint32_t i = 1; i + 1 < outline.size(); ++i) {
    if (outline.orientation(0, i, i + 1) != side) return {};
    triangles.push_back({0, i, i + 1});
  }
  return triangles;
}

template <class Outline>
bool isCollinear(const Outline& outline) {
  for (uint32_t i = 0; i < outline.size(); ++i) {
    if (turnAt(outline, i) != 0) return false;
  }
  return true;
}

template <class Outline>
void nameCorners(const Outline& outline, Triangles& triangles) {
  for (Triangle3& triangle : triangles) {
    for (uint32_t& point : triangle) point = outline.corners[point];
  }
}

enum class OutlineKind { simple, touching, crossing };  // touching itself, or without an area

struct Cut {
  Triangles triangles;  // of corners; none if the outline has no area, or crosses itself
  OutlineKind kind = OutlineKind::touching;
};

// Of an outline that does not touch itself; nothing if it does, or has no area.
template <class Outline>
std::optional<Cut> cutSimple(const Outline& outline) {
  if (outline.size() < 3) return {};
  Triangles triangles = fan(outline);
  if (triangles.empty() && !isCollinear(outline) && isSimple(outline)) triangles = triangulateSimple(outline);
  if (triangles.empty()) return {};
  nameCorners(outline, triangles);
  return Cut{std::move(triangles), OutlineKind::simple};
}

// Of one that does.
template <class Outline>
Cut cutTouching(const Outline& outline) {
  if (outline.size() < 3 || isCollinear(outline)) return {};
  std::optional<Triangles> triangles = triangulateTouching(outline.points, outline.corners);
  return triangles ? Cut{std::move(*triangles), OutlineKind::touching} : Cut{{}, OutlineKind::crossing};
}

// Whether the triangles end where the outline is: of their edges those are left over that are walked along it. Where it
// touches itself as it is seen, and not in space, they may end elsewhere.
bool keepsOutline(Corners corners, const Cut& cut, const std::vector<uint32_t>& distinct) {
  if (cut.kind == OutlineKind::simple) return cut.triangles.size() + 2 == distinct.size();
  if (cut.kind == OutlineKind::crossing) return false;
  const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::map<glm::dvec3, uint32_t, decltype(less)> places(less);
  std::map<std::pair<uint32_t, uint32_t>, int> surplus;  // of walks from the lesser place to the greater
  const auto walk = [&](uint32_t from, uint32_t to, int times) {
    const auto place = [&](uint32_t corner) { return places.emplace(corners[corner], corner).first->second; };
    const uint32_t a = place(from), b = place(to);
    surplus[std::minmax({a, b})] += a < b ? times : -times;
  };
  for (const auto& [a, b, c] : cut.triangles) {
    walk(a, b, 1);
    walk(b, c, 1);
    walk(c, a, 1);
  }
  for (size_t i = 0; i < distinct.size(); ++i) walk(distinct[i], distinct[(i + 1) % distinct.size()], -1);
  return std::all_of(surplus.begin(), surplus.end(), [](const auto& edge) { return edge.second == 0; });
}

// Whether no triangle is turned over, seen along the normal.
bool facesTheNormal(Corners corners, const Triangles& triangles, const Plane& plane) {
  return std::all_of(triangles.begin(), triangles.end(), [&](const Triangle3& triangle) {
    const auto place = [&](size_t k) { return plane.scale * corners[triangle[k]]; };
    return orientation(plane.normal, place(0), place(1), place(2)) > 0;
  });
}

CutPolygon cutAnyhow(Corners corners, const std::vector<uint32_t>& distinct, const Plane& plane) {
  CutPolygon result{.triangles = {}, .crossesItself = true};
  FlatOutline outline{.points = {}, .corners = distinct};
  for (const uint32_t corner : distinct) outline.points.push_back(plane.flatten(corners[corner]));
  result.triangles = triangulateAnyhow(outline);
  nameCorners(outline, result.triangles);
  return result;
}

// Whether a polygon of four is convex as seen along the axis, without straight corners.
bool isConvexQuad(Corners corners, const Plane& plane) {
  std::array<PlanePoint, 4> p;
  for (size_t i = 0; i < 4; ++i) p[i] = plane.flatten(corners[i]);
  const int side = orientation(p[0], p[1], p[2]);
  return side != 0 && orientation(p[1], p[2], p[3]) == side && orientation(p[2], p[3], p[0]) == side &&
         orientation(p[3], p[0], p[1]) == side;
}

// A polygon whose corners lie in no plane.
CutPolygon cutWarped(Corners corners, const Plane& plane) {
  const std::vector<uint32_t> distinct = distinctCorners(corners);
  const auto isWhole = [&](const std::optional<Cut>& cut) { return cut && keepsOutline(corners, *cut, distinct); };
  const auto isRight = [&](const std::optional<Cut>& cut) {
    return isWhole(cut) && facesTheNormal(corners, cut->triangles, plane);
  };
  const FlatOutline alongAxis = flatten(corners, plane);
  std::optional<Cut> flat = cutSimple(alongAxis);
  if (isRight(flat)) return {.triangles = std::move(flat->triangles)};
  const TiltedOutline alongNormal = tilt(corners, distinct, plane);
  std::optional<Cut> tilted = cutSimple(alongNormal);
  if (isRight(tilted)) return {.triangles = std::move(tilted->triangles)};
  // Last, what takes hundreds of times as long.
  if (!flat) flat = cutTouching(alongAxis);
  if (isRight(flat)) return {.triangles = std::move(flat->triangles)};
  if (!tilted) tilted = cutTouching(alongNormal);
  if (isRight(tilted)) return {.triangles = std::move(tilted->triangles)};
  // It crosses itself as seen along its normal, but not as seen along the axis.
  if (isWhole(flat)) return {.triangles = std::move(flat->triangles)};
  CutPolygon result{.triangles = triangulateAnyhow(alongNormal), .crossesItself = true};
  nameCorners(alongNormal, result.triangles);
  return result;
}

}  // namespace

CutPolygon triangulatePolygon(Corners corners) {
  if (corners.size() < 3) return {};
  const Plane plane = planeOf(corners);
  if (corners.size() == 3) {
    // What follows would say the same, but most polygons are triangles, and there are millions of them.
    const bool hasArea =
        orientation(plane.flatten(corners[0]), plane.flatten(corners[1]), plane.flatten(corners[2])) != 0;
    return {.triangles = hasArea ? Triangles{Triangle3{0, 1, 2}} : Triangles()};
  }
  if (corners.size() == 4 && isConvexQuad(corners, plane)) {
    // Likewise, for most of the others.
    Triangles fan{{0, 1, 2}, {0, 2, 3}};
    if (isPlanar(corners, plane) || facesTheNormal(corners, fan, plane)) return {.triangles = std::move(fan)};
  }
  if (!isPlanar(corners, plane)) return cutWarped(corners, plane);
  const FlatOutline outline = flatten(corners, plane);
  std::optional<Cut> flat = cutSimple(outline);
  if (!flat) flat = cutTouching(outline);
  if (flat->kind == OutlineKind::crossing) return cutAnyhow(corners, distinctCorners(corners), plane);
  return {.triangles = std::move(flat->triangles)};
}

}  // namespace turner
