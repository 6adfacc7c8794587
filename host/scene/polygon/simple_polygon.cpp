// Ear clipping, then Lawson's flips. That the ears cover the polygon needs no check of areas: an outline's winding
// numbers are the sum of those of the ears cut from it, so where all ears have positive area and the outline winds once
// around its inside, they cover the inside once.
#include "scene/polygon/simple_polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <numeric>
#include <span>
#include <utility>

#include "base/interrupt.h"

namespace turner {

namespace {

constexpr uint32_t kNone = UINT32_MAX;

struct Box {
  double left, right, low, high;
  bool meets(const Box& other) const {
    return left <= other.right && other.left <= right && low <= other.high && other.low <= high;
  }
  bool holds(PlanePoint p) const { return p.x >= left && p.x <= right && p.y >= low && p.y <= high; }
};

Box boxOf(PlanePoint a, PlanePoint b) {
  return {std::min(a.x, b.x), std::max(a.x, b.x), std::min(a.y, b.y), std::max(a.y, b.y)};
}

// So that a box of rounded points holds what it should.
template <class Outline>
Box grown(const Box& box) {
  constexpr double kBy = Outline::kRounding;
  return {box.left - kBy, box.right + kBy, box.low - kBy, box.high + kBy};
}

// Whether the edges that begin at two points, and whose boxes meet, have a point in common.
template <class Outline>
bool meet(const Outline& outline, uint32_t a, uint32_t c) {
  const uint32_t b = pointAfter(outline, a), d = pointAfter(outline, c);
  return outline.orientation(a, b, c) * outline.orientation(a, b, d) <= 0 &&
         outline.orientation(c, d, a) * outline.orientation(c, d, b) <= 0;
}

// The side to which the inside lies: 1 left, -1 right. The least point of an outline that does not cross itself is
// convex for certain, and tells.
int sideOf(const FlatOutline& outline) {
  const auto least = std::min_element(outline.points.begin(), outline.points.end());
  return turnAt(outline, uint32_t(least - outline.points.begin()));
}
int sideOf(const TiltedOutline&) {
  return 1;
}

// An outline from which ears are cut, one after the other.
template <class Outline>
class EarClipper {
 public:
  EarClipper(const Outline& outline, int side)
      : outline_(outline),
        points_(outline.points),
        before_(outline.size()),
        after_(outline.size()),
        convex_(outline.size()),
        side_(side) {
    for (uint32_t i = 0; i < outline.size(); ++i) {
      before_[i] = pointBefore(outline, i);
      after_[i] = pointAfter(outline, i);
    }
    for (uint32_t i = 0; i < outline.size(); ++i) {
      convex_[i] = turn(i) > 0;
      if (!convex_[i]) blocking_.push_back(i);
    }
  }

  // `anyhow`: where no ear is left, another corner is cut off; else there are no triangles then.
  std::vector<Triangle3> clip(bool anyhow) {
    std::vector<Triangle3> triangles;
    triangles.reserve(points_.size() - 2);
    // Cutting an ear makes or ends no others than those of its two neighbours: only they are looked at again. They wait
    // until all others have had their turn, so that ears are cut all around and not one behind the other as slivers.
    std::deque<uint32_t> waiting(points_.size());
    std::iota(waiting.begin(), waiting.end(), uint32_t(0));
    std::vector<uint32_t> timesWaiting(points_.size(), 1);
    uint32_t left = 0;  // one of the points that are left
    while (triangles.size() + 3 < points_.size()) {
      throwIfInterrupted();  // a polygon of 100,000 corners takes half a minute
      uint32_t i;
      if (!waiting.empty()) {
        i = waiting.front();
        waiting.pop_front();
        if (--timesWaiting[i] > 0 || !isEar(i)) continue;
      } else {
        if (!anyhow) return {};
        i = convexPoint(left);
      }
      triangles.push_back({before_[i], i, after_[i]});
      left = after_[i];
      remove(i, anyhow);
      for (const uint32_t neighbor : {before_[i], after_[i]}) {
        waiting.push_back(neighbor);
        ++timesWaiting[neighbor];
      }
    }
    // The three that are left are the last ear's neighbours and the one beyond them.
    const uint32_t last = triangles.empty() ? 0 : triangles.back()[0];
    if (!anyhow && turn(last) <= 0) return {};
    triangles.push_back({before_[last], last, after_[last]});
    return triangles;
  }

 private:
  // 1 where the outline turns around its inside, -1 where it turns away from it, 0 where it runs straight on.
  int turn(uint32_t i) const { return side_ * outline_.orientation(before_[i], i, after_[i]); }

  // Whether a triangle over a convex point lies inside, without touching the outline elsewhere. It is enough to look at
  // the points that are not convex: what enters the triangle has one of them inside.
  bool isEar(uint32_t i) const {
    if (!convex_[i]) return false;
    const uint32_t first = before_[i], last = after_[i];
    const PlanePoint a = points_[first], b = points_[i], c = points_[last];
    const Box box = grown<Outline>(
        {std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y})});
    return std::none_of(blocking_.begin(), blocking_.end(), [&](uint32_t k) {
      return box.holds(points_[k]) && k != first && k != last && side_ * outline_.orientation(first, i, k) >= 0 &&
             side_ * outline_.orientation(i, last, k) >= 0 && side_ * outline_.orientation(last, first, k) >= 0;
    });
  }

  // A convex point of those that are left, if there is one.
  uint32_t convexPoint(uint32_t start) const {
    uint32_t i = start;
    while (!convex_[i] && after_[i] != start) i = after_[i];
    return convex_[i] ? i : start;
  }

  void remove(uint32_t i, bool anyhow) {
    const uint32_t previous = before_[i], next = after_[i];
    after_[previous] = next;
    before_[next] = previous;
    if (!convex_[i]) blocking_.erase(std::find(blocking_.begin(), blocking_.end(), i));
    for (const uint32_t k : {previous, next}) {
      // A convex neighbour of an ear stays convex.
      if (convex_[k] && !anyhow) continue;
      const bool convex = turn(k) > 0;
      if (convex == bool(convex_[k])) continue;
      convex_[k] = convex;
      if (convex)
        blocking_.erase(std::find(blocking_.begin(), blocking_.end(), k));
      else
        blocking_.push_back(k);
    }
  }

  const Outline& outline_;
  std::span<const PlanePoint> points_;
  std::vector<uint32_t> before_, after_;
  std::vector<char> convex_;
  std::vector<uint32_t> blocking_;  // points left that are not convex
  int side_;
};

// Whether d lies within the circle through a, b and c (counter-clockwise for side 1, clockwise for -1), for certain: a
// flip then makes the triangulation strictly better, so that flips come to an end.
bool isCertainlyInCircle(PlanePoint a, PlanePoint b, PlanePoint c, PlanePoint d, int side) {
  const double ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x, cy = c.y - d.y;
  const double aa = ax * ax + ay * ay, bb = bx * bx + by * by, cc = cx * cx + cy * cy;
  const double determinant = aa * (bx * cy - cx * by) + bb * (cx * ay - ax * cy) + cc * (ax * by - bx * ay);
  // Shewchuk 1997, section 4.4.
  const double bound = 1.1102230246251577e-15 *
                       (aa * (std::abs(bx * cy) + std::abs(cx * by)) + bb * (std::abs(cx * ay) + std::abs(ax * cy)) +
                        cc * (std::abs(ax * by) + std::abs(bx * ay)));
  return side * determinant > bound;
}

// For each triangle, the ones beyond the edges that face its corners; kNone where the outline is.
std::vector<Triangle3> findNeighbors(std::span<const Triangle3> triangles) {
  struct HalfEdge {
    uint32_t low, high, triangle, corner;
  };
  std::vector<HalfEdge> edges;
  edges.reserve(3 * triangles.size());
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    for (uint32_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3]);
      edges.push_back({low, high, t, k});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const HalfEdge& a, const HalfEdge& b) { return std::pair(a.low, a.high) < std::pair(b.low, b.high); });
  std::vector<Triangle3> neighbors(triangles.size(), {kNone, kNone, kNone});
  for (size_t i = 1; i < edges.size(); ++i) {
    const HalfEdge &a = edges[i - 1], &b = edges[i];
    if (a.low != b.low || a.high != b.high) continue;
    neighbors[a.triangle][a.corner] = b.triangle;
    neighbors[b.triangle][b.corner] = a.triangle;
  }
  return neighbors;
}

size_t placeOf(const Triangle3& triangle, uint32_t value) {
  return size_t(std::find(triangle.begin(), triangle.end(), value) - triangle.begin());
}

// Lawson, "Software for C1 Surface Interpolation", 1977: as long as the point beyond an edge lies in the circle of the
// triangle before it, the other diagonal of the two is the better one.
template <class Outline>
void flipEdges(const Outline& outline, std::vector<Triangle3>& triangles, int side) {
  const std::span<const PlanePoint> points = outline.points;
  std::vector<Triangle3> neighbors = findNeighbors(triangles);
  std::vector<uint32_t> waiting(triangles.size());
  std::iota(waiting.begin(), waiting.end(), uint32_t(0));
  while (!waiting.empty()) {
    const uint32_t t = waiting.back();
    waiting.pop_back();
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t u = neighbors[t][k];
      if (u == kNone) continue;
      // Triangle t is a b c, and u is d c b.
      const size_t j = placeOf(neighbors[u], t);
      const uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3], c = triangles[t][(k + 2) % 3];
      const uint32_t d = triangles[u][j];
      if (!isCertainlyInCircle(points[a], points[b], points[c], points[d], side)) continue;
      if (side * outline.orientation(a, b, d) <= 0) continue;
      if (side * outline.orientation(a, d, c) <= 0) continue;
      const uint32_t beyondAb = neighbors[t][(k + 2) % 3], beyondCa = neighbors[t][(k + 1) % 3];
      const uint32_t beyondBd = neighbors[u][(j + 1) % 3], beyondDc = neighbors[u][(j + 2) % 3];
      triangles[t] = {a, b, d};
      neighbors[t] = {beyondBd, u, beyondAb};
      triangles[u] = {a, d, c};
      neighbors[u] = {beyondDc, beyondCa, t};
      if (beyondBd != kNone) neighbors[beyondBd][placeOf(neighbors[beyondBd], u)] = t;
      if (beyondCa != kNone) neighbors[beyondCa][placeOf(neighbors[beyondCa], t)] = u;
      waiting.push_back(t);
      waiting.push_back(u);
      break;
    }
  }
}

}  // namespace

template <class Outline>
bool isSimple(const Outline& outline) {
  const size_t count = outline.size();
  struct Segment {
    Box box;
    uint32_t index;
  };
  std::vector<Segment> segments;
  segments.reserve(count);
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t j = pointAfter(outline, i), k = pointAfter(outline, j);
    const PlanePoint a = outline.points[i], b = outline.points[j], c = outline.points[k];
    // Neighbours meet at their common end, and elsewhere only if the outline turns back on itself there.
    if (outline.orientation(i, j, k) == 0 && (a.x - b.x) * (c.x - b.x) + (a.y - b.y) * (c.y - b.y) > 0) return false;
    segments.push_back({grown<Outline>(boxOf(a, b)), i});
  }
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.box.left < b.box.left; });
  for (size_t i = 0; i < count; ++i) {
    throwIfInterrupted();
    for (size_t j = i + 1; j < count && segments[j].box.left <= segments[i].box.right; ++j) {
      if (!segments[i].box.meets(segments[j].box)) continue;
      const uint32_t first = segments[i].index, second = segments[j].index;
      if (pointAfter(outline, first) == second || pointAfter(outline, second) == first) continue;
      if (meet(outline, first, second)) return false;
    }
  }
  return true;
}

template <class Outline>
std::vector<Triangle3> triangulateSimple(const Outline& outline) {
  const int side = sideOf(outline);
  std::vector<Triangle3> triangles = EarClipper<Outline>(outline, side).clip(false);
  flipEdges(outline, triangles, side);
  return triangles;
}

template <class Outline>
std::vector<Triangle3> triangulateAnyhow(const Outline& outline) {
  return EarClipper<Outline>(outline, twiceArea(outline.points) < 0 ? -1 : 1).clip(true);
}

template bool isSimple(const FlatOutline&);
template bool isSimple(const TiltedOutline&);
template std::vector<Triangle3> triangulateSimple(const FlatOutline&);
template std::vector<Triangle3> triangulateSimple(const TiltedOutline&);
template std::vector<Triangle3> triangulateAnyhow(const FlatOutline&);
template std::vector<Triangle3> triangulateAnyhow(const TiltedOutline&);

}  // namespace turner
