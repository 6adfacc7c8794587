// Polygons become triangles that cover them exactly, wound as they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "scene/polygon/plane.h"
#include "scene/polygon/polygon.h"
#include "scene/polygon/simple_polygon.h"

namespace turner {
namespace {

using Corners = std::vector<glm::dvec3>;
using Triangles = std::vector<std::array<uint32_t, 3>>;

glm::dvec3 areaVector(const Corners& corners) {
  glm::dvec3 sum(0);
  for (size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += glm::cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  return sum;
}

// The sum of the areas is the polygon's, and no triangle is flipped: together, nothing is missing or covered twice.
void expectCovers(const Corners& corners, const Triangles& triangles) {
  const glm::dvec3 whole = areaVector(corners);
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    ASSERT_LT(std::max({a, b, c}), corners.size());
    const glm::dvec3 part = areaVector({corners[a], corners[b], corners[c]});
    EXPECT_GT(glm::dot(part, whole), 0) << "flipped or without area: " << a << ' ' << b << ' ' << c;
    sum += glm::length(part);
  }
  // The slack is the rounding of the areas themselves, which grows with the polygon's extent.
  double extent = 0;
  for (const glm::dvec3& corner : corners) extent = std::max(extent, glm::length(corner - corners[0]));
  EXPECT_NEAR(sum, glm::length(whole), 1e-12 * glm::length(whole) + 1e-16 * extent * extent * double(corners.size()));
}

Triangles cut(const Corners& corners) {
  const CutPolygon polygon = triangulatePolygon(corners);
  EXPECT_FALSE(polygon.crossesItself);
  return polygon.triangles;
}

// As many triangles as a triangulation over all corners has: no corner is left out, where a neighbour would crack.
void expectCutsAtAllCorners(const Corners& corners) {
  const Triangles triangles = cut(corners);
  EXPECT_EQ(triangles.size(), corners.size() - 2);
  std::set<uint32_t> used;
  for (const auto& triangle : triangles) used.insert(triangle.begin(), triangle.end());
  EXPECT_EQ(used.size(), corners.size());
  expectCovers(corners, triangles);
}

Corners reversed(Corners corners) {
  std::reverse(corners.begin(), corners.end());
  return corners;
}

// The plane of x and y, put askew into space.
Corners tilted(Corners corners) {
  const glm::dvec3 u(0.36, 0.48, -0.8), v(-0.8, 0.6, 0), origin(3, -2, 5);
  for (glm::dvec3& corner : corners) corner = origin + corner.x * u + corner.y * v;
  return corners;
}

Corners star(int tips, double inner) {
  Corners corners;
  for (int i = 0; i < 2 * tips; ++i) {
    const double angle = std::numbers::pi * i / tips, radius = i % 2 ? inner : 1;
    corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return corners;
}

// A wheel with teeth of four corners each, as in the SPD's gears.
Corners gear(int teeth) {
  Corners corners;
  for (int i = 0; i < 4 * teeth; ++i) {
    const double angle = 2 * std::numbers::pi * i / (4 * teeth), radius = i % 4 < 2 ? 1 : 0.8;
    corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0.25);
  }
  return corners;
}

Corners spiral(int points) {
  Corners corners;
  const auto at = [](int i, double extra) {
    const double angle = 0.1 * i, radius = angle + 1 + extra;
    return glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), 0);
  };
  for (int i = 0; i <= points; ++i) corners.push_back(at(i, 2));
  for (int i = points; i >= 0; --i) corners.push_back(at(i, 0));
  return corners;
}

Corners comb(int teeth) {
  Corners corners{{0, 0, 0}, {4.0 * teeth, 0, 0}};
  for (double x = 4.0 * (teeth - 1); x >= 0; x -= 4) {
    for (const auto& [dx, y] : {std::pair{4, 1}, {4, 10}, {2, 10}, {2, 1}}) corners.emplace_back(x + dx, y, 0);
  }
  return corners;
}

TEST(Polygon, TriangleStaysAsItIs) {
  EXPECT_EQ(cut(Corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}), (Triangles{{0, 1, 2}}));
  EXPECT_EQ(cut(Corners{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}), (Triangles{{0, 1, 2}}));
}

TEST(Polygon, ConvexPolygonBecomesFanFromItsFirstCorner) {
  const Corners pentagon = tilted({{1, 0, 0}, {0.3, 0.95, 0}, {-0.8, 0.6, 0}, {-0.8, -0.6, 0}, {0.3, -0.95, 0}});
  EXPECT_EQ(cut(pentagon), (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
  EXPECT_EQ(cut(reversed(pentagon)), (Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

TEST(Polygon, ConcavePolygonsAreCoveredInEveryOrientation) {
  for (const Corners& outline : {gear(36), star(5, 0.4), star(500, 0.01), star(50, 1e-6), spiral(300), comb(50),
                                 Corners{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {1, 1, 0}}}) {
    SCOPED_TRACE(std::to_string(outline.size()) + " corners");
    expectCutsAtAllCorners(outline);
    expectCutsAtAllCorners(reversed(outline));
    Corners turned = outline;
    for (glm::dvec3& corner : turned) corner = {corner.z, corner.x, corner.y};
    expectCutsAtAllCorners(turned);
  }
  for (const Corners& outline : {gear(36), star(5, 0.4), comb(5), spiral(30)}) {
    expectCutsAtAllCorners(tilted(outline));
  }
}

TEST(Polygon, GearOf144CornersBecomes142Triangles) {
  ASSERT_EQ(gear(36).size(), 144u);
  EXPECT_EQ(cut(gear(36)).size(), 142u);
}

TEST(Polygon, StraightCornersAreUsed) {
  expectCutsAtAllCorners({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
  expectCutsAtAllCorners({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}, {0, 2, 0}, {0, 1, 0}});
  // Here every fan would leave a corner out.
  expectCutsAtAllCorners(
      {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 3, 0}, {0, 2, 0}, {0, 1, 0}});
}

TEST(Polygon, NeedlesAreCut) {
  expectCutsAtAllCorners({{0, 0, 0}, {1, 1e-17, 0}, {2, 0, 0}, {1, 1, 0}});
  expectCutsAtAllCorners({{0, 0, 0}, {1, -1e-16, 0}, {2, 3e-16, 0}, {3, 0, 0}, {1.5, 1, 0}});
  expectCutsAtAllCorners({{0, 0, 0}, {1e8, 1e-8, 0}, {2e8, 0, 0}, {1e8, 2e-8, 0}});
  expectCutsAtAllCorners({{0, 0, 0}, {1e8, 1e-8, 0}, {2e8, 0, 0}, {1e8, 5e-9, 0}});
}

TEST(Polygon, SizeDoesNotMatter) {
  for (const double scale : {0x1p-300, 0x1p-100, 0x1p-40, 0x1p40, 0x1p99}) {
    SCOPED_TRACE(scale);
    Corners corners = gear(5);
    for (glm::dvec3& corner : corners) corner *= scale;
    const Triangles triangles = cut(corners);
    EXPECT_EQ(triangles, cut(gear(5)));
  }
}

TEST(Polygon, RepeatedCornersAreDropped) {
  const Corners corners{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  const Triangles triangles = cut(corners);
  EXPECT_EQ(triangles, (Triangles{{0, 2, 3}, {0, 3, 5}}));
}

TEST(Polygon, WithoutAreaGivesNoTriangles) {
  EXPECT_TRUE(cut({}).empty());
  EXPECT_TRUE(cut(Corners{{1, 2, 3}}).empty());
  EXPECT_TRUE(cut(Corners(5, glm::dvec3(1, 2, 3))).empty());
  EXPECT_TRUE(cut(Corners{{0, 0, 0}, {1, 2, 3}, {2, 4, 6}}).empty());
  EXPECT_TRUE(cut(Corners{{0, 0, 0}, {1, 2, 3}, {3, 6, 9}, {2, 4, 6}}).empty());
  // Walked there and back.
  EXPECT_TRUE(cut(Corners{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 0, 0}}).empty());
}

// 3 * 0.1 is not 0.3: such corners are on a line but for rounding, which may make them a sliver or an outline that
// crosses itself by a hair; nobody is to blame for that.
TEST(Polygon, LinesButForRoundingDoNotCross) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 500; ++trial) {
    Corners corners;
    for (int i = 0; i < 6; ++i) corners.push_back(double(random() % 10) * glm::dvec3(0.1, 0.7, -0.3));
    EXPECT_FALSE(triangulatePolygon(corners).crossesItself);
  }
}

// It is told of, and cut at all of its corners.
void expectCrosses(const Corners& corners) {
  const CutPolygon polygon = triangulatePolygon(corners);
  EXPECT_TRUE(polygon.crossesItself);
  EXPECT_EQ(polygon.triangles.size(), corners.size() - 2);
  std::set<uint32_t> used;
  for (const auto& triangle : polygon.triangles) used.insert(triangle.begin(), triangle.end());
  EXPECT_EQ(used.size(), corners.size());
}

TEST(Polygon, CrossingOutlinesAreCutAnyhow) {
  for (const Corners& outline :
       {Corners{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}}, Corners{{0, 0, 0}, {4, 4, 0}, {4, 0, 0}, {0, 2, 0}},
        Corners{{1, 0, 0}, {-0.8, 0.6, 0}, {0.3, -0.95, 0}, {0.3, 0.95, 0}, {-0.8, -0.6, 0}},
        Corners{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
        Corners{{0, 0, 0}, {9, 0, 0}, {9, 9, 0}, {10, 9, 0}, {8, 8.5, 0}, {0, 9, 0}},
        // A hole wound like the outer ring.
        Corners{{0, 0, 0},
                {4, 0, 0},
                {4, 4, 0},
                {0, 4, 0},
                {0, 0, 0},
                {1, 1, 0},
                {3, 1, 0},
                {3, 3, 0},
                {1, 3, 0},
                {1, 1, 0}}}) {
    for (const Corners& placed : {outline, reversed(outline), tilted(outline)}) expectCrosses(placed);
  }
}

// What crosses itself in one place keeps its shape elsewhere.
TEST(Polygon, CrossingIsALocalFault) {
  Corners corners = gear(36);
  const double whole = glm::length(areaVector(corners));
  std::swap(corners[0], corners[1]);
  expectCrosses(corners);
  double sum = 0;
  for (const auto& [a, b, c] : triangulatePolygon(corners).triangles)
    sum += glm::length(areaVector({corners[a], corners[b], corners[c]}));
  EXPECT_NEAR(sum, whole, 0.02 * whole);
}

TEST(Polygon, KeyHoleOutlinesKeepTheirHoles) {
  const Corners one{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                    {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  const Corners two{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0}, {1, 1, 0},   {1, 2, 0},   {2, 2, 0},
                    {2, 1, 0}, {1, 1, 0}, {0, 0, 0}, {3, 1, 0}, {3, 2, 0}, {3.5, 2, 0}, {3.5, 1, 0}, {3, 1, 0}};
  for (const Corners& outline : {one, two}) {
    for (const Corners& placed : {outline, reversed(outline), tilted(outline), reversed(tilted(outline))}) {
      const Triangles triangles = cut(placed);
      EXPECT_EQ(triangles.size(), placed.size() - 2);
      expectCovers(placed, triangles);
    }
  }
}

TEST(Polygon, PartsThatTouchAndSpikesAreAllowed) {
  for (const Corners& outline :
       {Corners{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}},
        Corners{{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}},
        Corners{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {6, 6, 0}, {4, 4, 0}, {0, 4, 0}},
        // A hole that touches the outer ring at a corner.
        Corners{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0}, {1, 3, 0}, {3, 1, 0}}}) {
    expectCovers(outline, cut(outline));
    expectCovers(reversed(outline), cut(reversed(outline)));
  }
}

// Any points, walked around a centre that lies among them: a simple polygon unless a gap is wider than half a turn.
TEST(Polygon, RandomOutlinesAreCoveredOrCross) {
  std::mt19937_64 random(1);
  const auto uniform = [&] { return double(random() >> 11) * 0x1p-53; };
  int covered = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    std::vector<double> angles(4 + random() % 60);
    for (double& angle : angles) angle = 2 * std::numbers::pi * uniform();
    std::sort(angles.begin(), angles.end());
    Corners corners;
    for (const double angle : angles) {
      const double radius = 0.1 + uniform();
      // Rounded coordinates make corners that are almost or exactly straight.
      corners.emplace_back(std::round(radius * std::cos(angle) * 64) / 64,
                           std::round(radius * std::sin(angle) * 64) / 64, 7);
    }
    const CutPolygon polygon = triangulatePolygon(corners);
    if (polygon.crossesItself) continue;
    expectCovers(corners, polygon.triangles);
    covered += !polygon.triangles.empty();
  }
  EXPECT_GT(covered, 500);
}

// Whole numbers of 40 bits: their products are exact in integers of 128 bits.
TEST(Polygon, OrientationIsExact) {
  std::mt19937_64 random(3);
  const auto coordinate = [&] { return int64_t(random() % (uint64_t(1) << 40)); };
  int straight = 0;
  for (int trial = 0; trial < 200'000; ++trial) {
    std::array<int64_t, 6> p{coordinate(), coordinate(), coordinate(), coordinate(), coordinate(), coordinate()};
    if (trial % 4 != 0) {
      // c on the line through a and b, or one step beside it.
      const auto along = int64_t(random() % 7) - 3;
      p[2] = p[0] + int64_t(random() % 4096), p[3] = p[1] + int64_t(random() % 4096);
      p[4] = p[0] + along * (p[2] - p[0]) + int64_t(random() % 2), p[5] = p[1] + along * (p[3] - p[1]);
    }
    __extension__ using Integer = __int128;
    const Integer determinant = Integer(p[0] - p[4]) * (p[3] - p[5]) - Integer(p[1] - p[5]) * (p[2] - p[4]);
    const int expected = determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
    straight += expected == 0;
    // A power of two changes nothing.
    const double scale = trial % 2 ? 0x1p-60 : 1;
    const auto point = [&](size_t k) { return PlanePoint{scale * double(p[k]), scale * double(p[k + 1])}; };
    ASSERT_EQ(orientation(point(0), point(2), point(4)), expected) << trial;
  }
  EXPECT_GT(straight, 50'000);
}

FlatOutline inPlane(const Corners& corners) {
  FlatOutline outline;
  for (const glm::dvec3& corner : corners) outline.points.push_back({corner.x, corner.y});
  return outline;
}

TEST(Polygon, SimpleOutlinesAreToldFromOthers) {
  for (const Corners& outline : {gear(36), star(5, 0.4), star(500, 0.01), spiral(300), comb(50)}) {
    EXPECT_TRUE(isSimple(inPlane(outline)));
    EXPECT_TRUE(isSimple(inPlane(reversed(outline))));
  }
  // Straight corners and needles touch nothing.
  EXPECT_TRUE(isSimple(inPlane({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}})));
  EXPECT_TRUE(isSimple(inPlane({{0, 0, 0}, {1e8, 1e-8, 0}, {2e8, 0, 0}, {1e8, 5e-9, 0}, {5e7, 4e-9, 0}})));
  // An 8; a corner on an edge; a corner on a corner; a spike; an edge along an edge.
  EXPECT_FALSE(isSimple(inPlane({{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}})));
  EXPECT_FALSE(isSimple(inPlane({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}})));
  EXPECT_FALSE(isSimple(inPlane({{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}})));
  EXPECT_FALSE(isSimple(inPlane({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {6, 6, 0}, {4, 4, 0}, {0, 4, 0}})));
  EXPECT_FALSE(isSimple(inPlane({{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {3, 0, 0}, {2, 0, 0}, {0, 4, 0}})));
}

// No point across an edge lies in the circle around a triangle: slivers are no worse than the outline makes them.
TEST(Polygon, TrianglesFollowDelaunaysRule) {
  for (const Corners& corners : {gear(36), star(5, 0.4), star(50, 0.3), spiral(100), comb(20)}) {
    SCOPED_TRACE(std::to_string(corners.size()) + " corners");
    const FlatOutline outline = inPlane(corners);
    const std::vector<PlanePoint>& points = outline.points;
    const Triangles triangles = triangulateSimple(outline);
    ASSERT_EQ(triangles.size(), points.size() - 2);
    int shared = 0;
    for (const auto& triangle : triangles) {
      for (const auto& other : triangles) {
        const auto apart = [](const auto& t, const auto& from) {
          std::vector<uint32_t> rest;
          for (const uint32_t i : t) {
            if (std::find(from.begin(), from.end(), i) == from.end()) rest.push_back(i);
          }
          return rest;
        };
        const std::vector<uint32_t> beyond = apart(other, triangle);
        if (beyond.size() != 1) continue;
        ++shared;
        const PlanePoint d = points[beyond[0]];
        std::array<long double, 3> x, y, square;
        for (size_t k = 0; k < 3; ++k) {
          x[k] = (long double)points[triangle[k]].x - d.x, y[k] = (long double)points[triangle[k]].y - d.y;
          square[k] = x[k] * x[k] + y[k] * y[k];
        }
        const long double inside = square[0] * (x[1] * y[2] - x[2] * y[1]) + square[1] * (x[2] * y[0] - x[0] * y[2]) +
                                   square[2] * (x[0] * y[1] - x[1] * y[0]);
        const long double size = square[0] + square[1] + square[2];
        EXPECT_LE(inside, 1e-14L * size * size);
      }
    }
    EXPECT_EQ(shared, 2 * int(triangles.size() - 1));
  }
}

// Their cost must not be that of their corners squared many times over: this took minutes once.
TEST(Polygon, LongOutlinesAreCut) {
  expectCutsAtAllCorners(spiral(5000));
  expectCutsAtAllCorners(gear(2500));
}

}  // namespace
}  // namespace turner
