// GEOS's triangles are matched to corners by equality.
#include "scene/polygon/touching_polygon.h"

#include <geos_c.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <span>
#include <utility>

namespace turner {

namespace {

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

// Whether all points lie on one line but for what rounding to double has moved them.
bool isCollinearButForRounding(const std::vector<PlanePoint>& points) {
  const PlanePoint a = *std::min_element(points.begin(), points.end());
  const PlanePoint b = *std::max_element(points.begin(), points.end());
  // Sizes are about 1 here (polygon.cpp), a double's step is 2e-16, and a distance sums a few of them.
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  return std::all_of(points.begin(), points.end(), [&](PlanePoint p) {
    return std::abs((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) <= 2e-15 * length;
  });
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

Geometry makePolygon(const std::vector<PlanePoint>& points) {
  GEOSGeometry* ring = GEOSGeom_createLinearRing_r(geos(), makeSequence(points, true));
  return Geometry(ring ? GEOSGeom_createPolygon_r(geos(), ring, nullptr, 0) : nullptr);
}

bool isValid(const Geometry& geometry) {
  return geometry && GEOSisValid_r(geos(), geometry.get()) == 1;
}

// The outline's edges, each cut where another of its points lies on it.
std::vector<Edge> cutEdges(const std::vector<PlanePoint>& points) {
  std::vector<Edge> edges;
  for (size_t i = 0; i < points.size(); ++i) {
    const PlanePoint a = points[i], b = points[i + 1 == points.size() ? 0 : i + 1];
    const auto [left, right] = std::minmax(a.x, b.x);
    const auto [low, high] = std::minmax(a.y, b.y);
    std::set<PlanePoint> cuts{a, b};
    for (const PlanePoint p : points) {
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

// What GEOS shall cut: null, with `hasArea` false, where nothing remains but edges walked there and back, and null
// where the outline crosses itself.
Geometry triangulable(const std::vector<PlanePoint>& points, bool& hasArea) {
  hasArea = true;
  Geometry polygon = makePolygon(points);
  if (isValid(polygon)) return polygon;
  // Not a simple polygon, but it may be one with holes or with parts that touch, drawn in one go.
  const std::vector<Edge> edges = withoutBridges(cutEdges(points));
  hasArea = !edges.empty();
  if (!hasArea) return nullptr;
  Geometry area = makeArea(edges);
  double size = 0;
  const bool valid = isValid(area) && GEOSArea_r(geos(), area.get(), &size) == 1 && size > 0;
  // A hole wound like the outer ring, or an outline walked twice, counts doubly in the signed area.
  const double expected = double(std::abs(twiceArea(points)) / 2);
  if (valid && std::abs(size - expected) <= 1e-9 * expected) return area;
  hasArea = !isCollinearButForRounding(points);
  return nullptr;
}

std::array<PlanePoint, 3> pointsOf(const GEOSGeometry* triangle) {
  const GEOSCoordSequence* sequence = GEOSGeom_getCoordSeq_r(geos(), GEOSGetExteriorRing_r(geos(), triangle));
  std::array<PlanePoint, 3> points;
  for (unsigned k = 0; k < 3; ++k) GEOSCoordSeq_getXY_r(geos(), sequence, k, &points[k].x, &points[k].y);
  return points;
}

std::optional<std::vector<Triangle3>> constrainedDelaunay(const std::vector<PlanePoint>& outline,
                                                          const std::vector<uint32_t>& corners,
                                                          const GEOSGeometry* area) {
  const Geometry pieces(GEOSConstrainedDelaunayTriangulation_r(geos(), area));
  if (!pieces) return std::nullopt;

  std::map<PlanePoint, uint32_t> cornerAt;
  for (size_t i = 0; i < outline.size(); ++i) cornerAt.emplace(outline[i], corners[i]);
  const long double signedArea = twiceArea(outline);
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
      if (corner == cornerAt.end()) return std::nullopt;
      triangle[k] = corner->second;
    }
    triangles.push_back(triangle);
  }
  // Nothing may be lost or covered twice. The slack covers needles, whose areas are mostly rounding.
  const long double slack = 1e-9L * std::abs(signedArea) + 1e-17L * (long double)outline.size();
  return std::abs(sum - signedArea) <= slack ? std::optional(std::move(triangles)) : std::nullopt;
}

}  // namespace

std::optional<std::vector<Triangle3>> triangulateTouching(const std::vector<PlanePoint>& points,
                                                          const std::vector<uint32_t>& corners) {
  bool hasArea;
  const Geometry area = triangulable(points, hasArea);
  if (!hasArea) return std::vector<Triangle3>();
  return area ? constrainedDelaunay(points, corners, area.get()) : std::nullopt;
}

}  // namespace turner
