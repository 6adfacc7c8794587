// Ear clipping, then Lawson's flips. That the ears cover the polygon needs no check of areas: an outline's winding
// numbers are the sum of those of the ears cut from it, so where all ears have positive area and the outline winds once
// around its inside, they cover the inside once.
#include "scene/polygon/simple_polygon.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <numeric>
#include <utility>

namespace turner {

namespace {

using Triangle3 = std::array<uint32_t, 3>;
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

// Whether two segments whose boxes meet have a point in common.
bool meet(PlanePoint a, PlanePoint b, PlanePoint c, PlanePoint d) {
  return orientation(a, b, c) * orientation(a, b, d) <= 0 && orientation(c, d, a) * orientation(c, d, b) <= 0;
}

// An outline from which ears are cut, one after the other.
class EarClipper {
 public:
  explicit EarClipper(std::span<const PlanePoint> outline)
      : points_(outline), before_(outline.size()), after_(outline.size()), convex_(outline.size()) {
    const auto count = uint32_t(outline.size());
    for (uint32_t i = 0; i < count; ++i) {
      before_[i] = i == 0 ? count - 1 : i - 1;
      after_[i] = i + 1 == count ? 0 : i + 1;
    }
    // The least point is convex for certain, and so tells to which side the inside lies.
    const auto least = uint32_t(std::min_element(outline.begin(), outline.end()) - outline.begin());
    side_ = orientation(points_[before_[least]], points_[least], points_[after_[least]]);
    for (uint32_t i = 0; i < count; ++i) {
      convex_[i] = turn(i) > 0;
      if (!convex_[i]) blocking_.push_back(i);
    }
  }

  int side() const { return side_; }

  std::vector<Triangle3> clip() {
    std::vector<Triangle3> triangles;
    triangles.reserve(points_.size() - 2);
    // Cutting an ear makes or ends no others than those of its two neighbours: only they are looked at again. They wait
    // until all others have had their turn, so that ears are cut all around and not one behind the other as slivers.
    std::deque<uint32_t> waiting(points_.size());
    std::iota(waiting.begin(), waiting.end(), uint32_t(0));
    std::vector<uint32_t> timesWaiting(points_.size(), 1);
    while (triangles.size() + 3 < points_.size()) {
      if (waiting.empty()) return {};
      const uint32_t i = waiting.front();
      waiting.pop_front();
      if (--timesWaiting[i] > 0 || !isEar(i)) continue;
      triangles.push_back({before_[i], i, after_[i]});
      remove(i);
      for (const uint32_t neighbor : {before_[i], after_[i]}) {
        waiting.push_back(neighbor);
        ++timesWaiting[neighbor];
      }
    }
    // The three that are left are the last ear's neighbours and the one beyond them.
    const uint32_t last = triangles.empty() ? 0 : triangles.back()[0];
    if (turn(last) <= 0) return {};
    triangles.push_back({before_[last], last, after_[last]});
    return triangles;
  }

 private:
  // 1 where the outline turns around its inside, -1 where it turns away from it, 0 where it runs straight on.
  int turn(uint32_t i) const { return side_ * orientation(points_[before_[i]], points_[i], points_[after_[i]]); }

  // Whether a triangle over a convex point lies inside, without touching the outline elsewhere. It is enough to look at
  // the points that are not convex: what enters the triangle has one of them inside.
  bool isEar(uint32_t i) const {
    if (!convex_[i]) return false;
    const PlanePoint a = points_[before_[i]], b = points_[i], c = points_[after_[i]];
    const Box box{std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}),
                  std::max({a.y, b.y, c.y})};
    return std::none_of(blocking_.begin(), blocking_.end(), [&](uint32_t k) {
      const PlanePoint p = points_[k];
      return box.holds(p) && k != before_[i] && k != after_[i] && side_ * orientation(a, b, p) >= 0 &&
             side_ * orientation(b, c, p) >= 0 && side_ * orientation(c, a, p) >= 0;
    });
  }

  void remove(uint32_t i) {
    const uint32_t previous = before_[i], next = after_[i];
    after_[previous] = next;
    before_[next] = previous;
    for (const uint32_t k : {previous, next}) {
      if (convex_[k] || turn(k) <= 0) continue;
      convex_[k] = true;
      blocking_.erase(std::find(blocking_.begin(), blocking_.end(), k));
    }
  }

  std::span<const PlanePoint> points_;
  std::vector<uint32_t> before_, after_;
  std::vector<char> convex_;
  std::vector<uint32_t> blocking_;  // points left that are not convex
  int side_ = 0;
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
void flipEdges(std::span<const PlanePoint> points, std::vector<Triangle3>& triangles, int side) {
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
      if (side * orientation(points[a], points[b], points[d]) <= 0) continue;
      if (side * orientation(points[a], points[d], points[c]) <= 0) continue;
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

bool isSimple(std::span<const PlanePoint> outline) {
  const size_t count = outline.size();
  struct Segment {
    Box box;
    uint32_t index;
  };
  std::vector<Segment> segments;
  segments.reserve(count);
  const auto after = [&](size_t i) { return i + 1 == count ? 0 : i + 1; };
  for (size_t i = 0; i < count; ++i) {
    const PlanePoint a = outline[i], b = outline[after(i)], c = outline[after(after(i))];
    // Neighbours meet at their common end, and elsewhere only if the outline turns back on itself there.
    if (orientation(a, b, c) == 0 && (a.x - b.x) * (c.x - b.x) + (a.y - b.y) * (c.y - b.y) > 0) return false;
    segments.push_back({boxOf(a, b), uint32_t(i)});
  }
  std::sort(segments.begin(), segments.end(),
            [](const Segment& a, const Segment& b) { return a.box.left < b.box.left; });
  for (size_t i = 0; i < count; ++i) {
    for (size_t j = i + 1; j < count && segments[j].box.left <= segments[i].box.right; ++j) {
      if (!segments[i].box.meets(segments[j].box)) continue;
      const size_t first = segments[i].index, second = segments[j].index;
      if (after(first) == second || after(second) == first) continue;
      if (meet(outline[first], outline[after(first)], outline[second], outline[after(second)])) return false;
    }
  }
  return true;
}

std::vector<Triangle3> triangulateSimple(std::span<const PlanePoint> outline) {
  EarClipper clipper(outline);
  std::vector<Triangle3> triangles = clipper.clip();
  flipEdges(outline, triangles, clipper.side());
  return triangles;
}

}  // namespace turner
