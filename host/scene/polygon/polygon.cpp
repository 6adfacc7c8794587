// In: the corners of a polygon in space. Out: triangles over them. The polygon is projected along the axis to which its
// normal is closest, by dropping that coordinate: the points of the plane are then the input's own numbers. Outlines
// that touch themselves go to GEOS, whose triangles are matched to corners by equality.
#include "scene/polygon/polygon.h"

#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "scene/polygon/plane.h"
#include "scene/polygon/simple_polygon.h"

namespace turner {

namespace {

using Triangle3 = std::array<uint32_t, 3>;
using Edge = std::pair<PlanePoint, PlanePoint>;

// GEOS wants one context for each thread. Its errors come back as null results, which are handled where they arise.
GEOSContextHandle_t geos() {
  struct Finish {
    void operator()(GEOSContextHandle_HS* context) const { GEOS_finish_r(context); }
  };
  thread_local const std::unique_ptr<GEOSContextHandle_HS, Finish> context(GEOS_init_r());
  if (!context) throw std::bad_alloc();
  return context.get();
}

struct DestroyGeometry {
  void operator()(GEOSGeometry* geometry) const { GEOSGeom_destroy_r(geos(), geometry); }
};
using Geometry = std::unique_ptr<GEOSGeometry, DestroyGeometry>;

// The outline in the plane: points, and the corner that each of them is. No point equals its successor.
struct Outline {
  std::vector<PlanePoint> points;
  std::vector<uint32_t> corners;

  size_t size() const { return points.size(); }
  size_t after(size_t i) const { return i + 1 == points.size() ? 0 : i + 1; }
  size_t before(size_t i) const { return i == 0 ? points.size() - 1 : i - 1; }
  int turn(size_t i) const { return orientation(points[before(i)], points[i], points[after(i)]); }
};

// The axis to which the normal of the polygon, times `scale`, is closest (Newell's method).
int dominantAxis(std::span<const glm::dvec3> corners, double scale) {
  glm::dvec3 normal(0), magnitude(0);
  const glm::dvec3 first = scale * corners[0];
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    const glm::dvec3 part = glm::cross(scale * corners[i] - first, scale * corners[i + 1] - first);
    normal += part;
    magnitude += glm::abs(part);
  }
  const auto largest = [](const glm::dvec3& v) { return v.x >= v.y && v.x >= v.z ? 0 : v.y >= v.z ? 1 : 2; };
  // Where the parts cancel (an outline like an 8), the sum is rounding noise and says nothing about the plane.
  const glm::dvec3 absolute = glm::abs(normal);
  const int axis = largest(absolute);
  return absolute[axis] > 1e-12 * magnitude[largest(magnitude)] ? axis : largest(magnitude);
}

// Drops the axis, keeping the orientation. A power of two brings the size to about 1: that is exact, and products of
// very small or large coordinates neither vanish nor overflow.
struct Projection {
  double scale;
  int first, second;  // the axes that are left

  PlanePoint operator()(const glm::dvec3& corner) const { return {scale * corner[first], scale * corner[second]}; }
};

// At least one corner.
Projection projectionOf(std::span<const glm::dvec3> corners) {
  double extent = 0;
  for (const glm::dvec3& corner : corners) {
    extent = std::max({extent, std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
  }
  const double scale = extent > 0 ? std::scalbn(1.0, std::clamp(-std::ilogb(extent), -1000, 1000)) : 1;
  const int axis = dominantAxis(corners, scale);
  return {scale, (axis + 1) % 3, (axis + 2) % 3};
}

Outline project(std::span<const glm::dvec3> corners) {
  const Projection projection = projectionOf(corners);
  Outline outline;
  outline.points.reserve(corners.size());
  outline.corners.reserve(corners.size());
  for (uint32_t i = 0; i < corners.size(); ++i) {
    const PlanePoint point = projection(corners[i]);
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

// Whether a point runs to and fro along the outline just once: with turns to one side only, that is a convex polygon.
bool windsOnce(const Outline& outline) {
  int changes = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const bool rises = outline.points[i] < outline.points[outline.after(i)];
    const bool roseBefore = outline.points[outline.before(i)] < outline.points[i];
    changes += rises != roseBefore;
  }
  return changes == 2;
}

// The fan from point 0, or nothing where a fan is not right: the polygon is not convex, or a straight corner beside
// point 0 would be left out of all triangles, so that a neighbour that uses it would leave a crack.
std::vector<Triangle3> fan(const Outline& outline) {
  int side = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const int turn = outline.turn(i);
    if (turn * side < 0) return {};
    if (turn != 0) side = turn;
  }
  if (side == 0 || !windsOnce(outline)) return {};
  std::vector<Triangle3> triangles;
  triangles.reserve(outline.size() - 2);
  for (size_t i = 1; i + 1 < outline.size(); ++i) {
    if (orientation(outline.points[0], outline.points[i], outline.points[i + 1]) != side) return {};
    triangles.push_back({outline.corners[0], outline.corners[i], outline.corners[i + 1]});
  }
  return triangles;
}

bool isCollinear(const Outline& outline) {
  for (size_t i = 0; i < outline.size(); ++i) {
    if (outline.turn(i) != 0) return false;
  }
  return true;
}

// Whether all points lie on one line but for what rounding to double has moved them.
bool isCollinearButForRounding(const Outline& outline) {
  const PlanePoint a = *std::min_element(outline.points.begin(), outline.points.end());
  const PlanePoint b = *std::max_element(outline.points.begin(), outline.points.end());
  // Sizes are about 1 here (project), a double's step is 2e-16, and a distance sums a few of them.
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  return std::all_of(outline.points.begin(), outline.points.end(), [&](PlanePoint p) {
    return std::abs((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) <= 2e-15 * length;
  });
}

// Twice the signed area; long double, as it is compared with sums of other roundings.
long double twiceArea(std::span<const PlanePoint> points) {
  long double sum = 0;
  for (size_t i = 1; i + 1 < points.size(); ++i) {
    const long double ax = (long double)points[i].x - points[0].x, ay = (long double)points[i].y - points[0].y;
    const long double bx = (long double)points[i + 1].x - points[0].x, by = (long double)points[i + 1].y - points[0].y;
    sum += ax * by - ay * bx;
  }
  return sum;
}

GEOSCoordSequence* makeSequence(std::span<const PlanePoint> points, bool closed) {
  const auto count = unsigned(points.size() + (closed ? 1 : 0));
  GEOSCoordSequence* sequence = GEOSCoordSeq_create_r(geos(), count, 2);
  if (!sequence) throw std::bad_alloc();
  for (unsigned i = 0; i < count; ++i) {
    const PlanePoint point = points[i % points.size()];
    GEOSCoordSeq_setXY_r(geos(), sequence, i, point.x, point.y);
  }
  return sequence;
}

Geometry makePolygon(const Outline& outline) {
  GEOSGeometry* ring = GEOSGeom_createLinearRing_r(geos(), makeSequence(outline.points, true));
  return Geometry(ring ? GEOSGeom_createPolygon_r(geos(), ring, nullptr, 0) : nullptr);
}

bool isValid(const Geometry& geometry) {
  return geometry && GEOSisValid_r(geos(), geometry.get()) == 1;
}

// The outline's edges, each cut where another of its points lies on it.
std::vector<Edge> cutEdges(const Outline& outline) {
  std::vector<Edge> edges;
  for (size_t i = 0; i < outline.size(); ++i) {
    const PlanePoint a = outline.points[i], b = outline.points[outline.after(i)];
    const auto [left, right] = std::minmax(a.x, b.x);
    const auto [low, high] = std::minmax(a.y, b.y);
    std::set<PlanePoint> cuts{a, b};
    for (const PlanePoint p : outline.points) {
      if (p.x < left || p.x > right || p.y < low || p.y > high || orientation(a, b, p) != 0) continue;
      cuts.insert(p);
    }
    std::vector<PlanePoint> path(cuts.begin(), cuts.end());
    if (b < a) std::reverse(path.begin(), path.end());
    for (size_t k = 0; k + 1 < path.size(); ++k) edges.emplace_back(path[k], path[k + 1]);
  }
  return edges;
}

// Drops the edges that are walked there and back: the bridges to the holes of a key-hole outline, and spikes.
std::vector<Edge> withoutBridges(const std::vector<Edge>& edges) {
  std::map<Edge, int> surplus;  // of walks from the lesser point to the greater
  for (const auto& [from, to] : edges) {
    if (from < to) {
      ++surplus[{from, to}];
    } else {
      --surplus[{to, from}];
    }
  }
  std::vector<Edge> kept;
  for (const auto& [edge, count] : surplus) {
    if (count != 0) kept.push_back(edge);
  }
  return kept;
}

// The area within the edges, as polygons with holes.
Geometry makeArea(const std::vector<Edge>& edges) {
  std::vector<GEOSGeometry*> lines;
  for (const auto& [from, to] : edges) {
    const std::array<PlanePoint, 2> ends{from, to};
    lines.push_back(GEOSGeom_createLineString_r(geos(), makeSequence(ends, false)));
  }
  const Geometry all(GEOSGeom_createCollection_r(geos(), GEOS_MULTILINESTRING, lines.data(), unsigned(lines.size())));
  return Geometry(all ? GEOSBuildArea_r(geos(), all.get()) : nullptr);
}

// Says at which corner GEOS found the fault.
std::string describeCrossing(const Outline& outline) {
  const Geometry polygon = makePolygon(outline);
  char* reason = nullptr;
  GEOSGeometry* location = nullptr;
  if (polygon) GEOSisValidDetail_r(geos(), polygon.get(), 0, &reason, &location);
  const Geometry place(location);
  GEOSFree_r(geos(), reason);
  const std::string message = "the outline crosses or overlaps itself";
  PlanePoint at;
  if (!place || GEOSGeomGetX_r(geos(), place.get(), &at.x) != 1 || GEOSGeomGetY_r(geos(), place.get(), &at.y) != 1) {
    return message;
  }
  size_t nearest = 0;
  const auto distance = [&](size_t i) { return std::hypot(outline.points[i].x - at.x, outline.points[i].y - at.y); };
  for (size_t i = 1; i < outline.size(); ++i) {
    if (distance(i) < distance(nearest)) nearest = i;
  }
  return message + " near its corner " + std::to_string(outline.corners[nearest] + 1);
}

// What GEOS shall cut. Empty where nothing remains but edges walked there and back.
Geometry triangulable(const Outline& outline) {
  Geometry polygon = makePolygon(outline);
  if (isValid(polygon)) return polygon;
  // Not a simple polygon, but it may be one with holes or with parts that touch, drawn in one go.
  const std::vector<Edge> edges = withoutBridges(cutEdges(outline));
  if (edges.empty()) return nullptr;
  Geometry area = makeArea(edges);
  double size = 0;
  const bool valid = isValid(area) && GEOSArea_r(geos(), area.get(), &size) == 1 && size > 0;
  // A hole wound like the outer ring, or an outline walked twice, counts doubly in the signed area.
  const double expected = double(std::abs(twiceArea(outline.points)) / 2);
  if (valid && std::abs(size - expected) <= 1e-9 * expected) return area;
  if (isCollinearButForRounding(outline)) return nullptr;
  throw std::invalid_argument(describeCrossing(outline));
}

std::array<PlanePoint, 3> pointsOf(const GEOSGeometry* triangle) {
  const GEOSCoordSequence* sequence = GEOSGeom_getCoordSeq_r(geos(), GEOSGetExteriorRing_r(geos(), triangle));
  std::array<PlanePoint, 3> points;
  for (unsigned k = 0; k < 3; ++k) GEOSCoordSeq_getXY_r(geos(), sequence, k, &points[k].x, &points[k].y);
  return points;
}

std::vector<Triangle3> constrainedDelaunay(const Outline& outline, const GEOSGeometry* area) {
  const auto failure = [] { return std::invalid_argument("the outline cannot be cut into triangles; split it"); };
  const Geometry pieces(GEOSConstrainedDelaunayTriangulation_r(geos(), area));
  if (!pieces) throw failure();

  std::map<PlanePoint, uint32_t> cornerAt;
  for (size_t i = 0; i < outline.size(); ++i) cornerAt.emplace(outline.points[i], outline.corners[i]);
  const long double signedArea = twiceArea(outline.points);
  const int side = signedArea > 0 ? 1 : -1;
  long double sum = 0;
  std::vector<Triangle3> triangles;
  const int count = GEOSGetNumGeometries_r(geos(), pieces.get());
  for (int i = 0; i < count; ++i) {
    std::array<PlanePoint, 3> points = pointsOf(GEOSGetGeometryN_r(geos(), pieces.get(), i));
    const int turn = orientation(points[0], points[1], points[2]);
    if (turn == 0) continue;
    if (turn != side) std::swap(points[1], points[2]);
    sum += twiceArea(points);
    Triangle3 triangle;
    for (size_t k = 0; k < 3; ++k) {
      const auto corner = cornerAt.find(points[k]);
      if (corner == cornerAt.end()) throw failure();
      triangle[k] = corner->second;
    }
    triangles.push_back(triangle);
  }
  // Nothing may be lost or covered twice. The slack covers needles, whose areas are mostly rounding.
  if (std::abs(sum - signedArea) > 1e-9L * std::abs(signedArea) + 1e-17L * (long double)outline.size()) throw failure();
  return triangles;
}

}  // namespace

std::vector<Triangle3> triangulatePolygon(std::span<const glm::dvec3> corners) {
  if (corners.size() < 3) return {};
  if (corners.size() == 3) {
    // What follows would say the same, but most polygons are triangles, and there are millions of them.
    const Projection project3 = projectionOf(corners);
    const bool hasArea = orientation(project3(corners[0]), project3(corners[1]), project3(corners[2])) != 0;
    return hasArea ? std::vector<Triangle3>{Triangle3{0, 1, 2}} : std::vector<Triangle3>();
  }
  const Outline outline = project(corners);
  if (outline.size() < 3) return {};
  if (std::vector<Triangle3> triangles = fan(outline); !triangles.empty()) return triangles;
  if (isCollinear(outline)) return {};
  if (isSimple(outline.points)) {
    std::vector<Triangle3> triangles = triangulateSimple(outline.points);
    for (Triangle3& triangle : triangles) {
      for (uint32_t& point : triangle) point = outline.corners[point];
    }
    if (!triangles.empty()) return triangles;
  }
  const Geometry area = triangulable(outline);
  return area ? constrainedDelaunay(outline, area.get()) : std::vector<Triangle3>();
}

}  // namespace turner
