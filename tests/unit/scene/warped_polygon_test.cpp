// Polygons whose corners lie in no plane, against an oracle in whole numbers: the outline as it is seen along its own
// normal.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "scene/polygon/polygon.h"

namespace turner {
namespace {

__extension__ using Integer = __int128;
using Vector = std::array<Integer, 3>;
using Outline = std::vector<Vector>;

Vector operator-(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Integer dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector normalOf(const Outline& outline) {
  Vector normal{};
  for (size_t i = 0; i < outline.size(); ++i) {
    const Vector part = cross(outline[i], outline[(i + 1) % outline.size()]);
    for (size_t k = 0; k < 3; ++k) normal[k] += part[k];
  }
  return normal;
}

// The plane across a normal.
struct View {
  Vector normal;

  // Of a triangle: twice its area times the length of the normal.
  Integer area(const Vector& a, const Vector& b, const Vector& c) const { return dot(normal, cross(b - a, c - a)); }
  int side(const Vector& a, const Vector& b, const Vector& c) const {
    const Integer size = area(a, b, c);
    return size > 0 ? 1 : size < 0 ? -1 : 0;
  }
  // The scalar product as it is seen, times the square of the normal's length.
  Integer dotSeen(const Vector& u, const Vector& v) const {
    return dot(u, v) * dot(normal, normal) - dot(u, normal) * dot(v, normal);
  }
  // Whether p, which lies on the line through a and b, lies between them.
  bool isBetween(const Vector& p, const Vector& a, const Vector& b) const { return dotSeen(a - p, b - p) <= 0; }
  bool meet(const Vector& a, const Vector& b, const Vector& c, const Vector& d) const {
    const int abc = side(a, b, c), abd = side(a, b, d), cda = side(c, d, a), cdb = side(c, d, b);
    if (abc * abd < 0 && cda * cdb < 0) return true;
    return (abc == 0 && isBetween(c, a, b)) || (abd == 0 && isBetween(d, a, b)) || (cda == 0 && isBetween(a, c, d)) ||
           (cdb == 0 && isBetween(b, c, d));
  }
  bool isSimple(const Outline& outline) const {
    const size_t count = outline.size();
    for (size_t i = 0; i < count; ++i) {
      const Vector &a = outline[i], &b = outline[(i + 1) % count], &c = outline[(i + 2) % count];
      if (dotSeen(a - b, a - b) == 0) return false;
      if (side(a, b, c) == 0 && dotSeen(a - b, c - b) > 0) return false;
      for (size_t j = i + 2; j < count; ++j) {
        if ((j + 1) % count != i && meet(a, b, outline[j], outline[(j + 1) % count])) return false;
      }
    }
    return true;
  }
};

// True if the outline is simple as it is seen along its normal.
bool expectCut(const Outline& outline) {
  std::vector<glm::dvec3> corners;
  for (const Vector& corner : outline) corners.emplace_back(double(corner[0]), double(corner[1]), double(corner[2]));
  const CutPolygon polygon = triangulatePolygon(corners);

  const View view{normalOf(outline)};
  const bool isSimple = view.normal != Vector{} && view.isSimple(outline);
  std::vector<bool> isUsed(outline.size());
  Integer sum = 0;
  bool isTurnedOver = false;
  for (const auto& [a, b, c] : polygon.triangles) {
    isUsed[a] = isUsed[b] = isUsed[c] = true;
    sum += view.area(outline[a], outline[b], outline[c]);
    isTurnedOver |= view.side(outline[a], outline[b], outline[c]) <= 0;
  }
  if (isSimple || polygon.crossesItself) {
    EXPECT_EQ(polygon.triangles.size(), outline.size() - 2);
    EXPECT_EQ(std::count(isUsed.begin(), isUsed.end(), false), 0);
  }
  if (isSimple) {
    EXPECT_FALSE(polygon.crossesItself);
    EXPECT_FALSE(isTurnedOver);
    EXPECT_TRUE(sum == dot(view.normal, view.normal));
  }
  return isSimple;
}

class Random {
 public:
  Integer upTo(int64_t most) { return Integer(int64_t(random_() % uint64_t(2 * most + 1)) - most); }
  double share() { return double(random_() >> 11) * 0x1p-53; }

  // Corners anywhere in a box of three sizes.
  Outline anyOutline(size_t count, const std::array<int64_t, 3>& sizes) {
    Outline outline;
    for (size_t i = 0; i < count; ++i) outline.push_back({upTo(sizes[0]), upTo(sizes[1]), upTo(sizes[2])});
    return outline;
  }

  // Around an axis, at heights of its own: mostly simple, often concave.
  Outline roundOutline(size_t count, int64_t size, int64_t height, size_t axis) {
    Outline outline;
    for (size_t i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * (double(i) + share()) / double(count);
      const double radius = double(size) * (0.2 + 0.8 * share());
      Vector corner;
      corner[axis] = upTo(height);
      corner[(axis + 1) % 3] = Integer(std::lround(radius * std::cos(angle)));
      corner[(axis + 2) % 3] = Integer(std::lround(radius * std::sin(angle)));
      outline.push_back(corner);
    }
    return outline;
  }

 private:
  std::mt19937_64 random_{1};
};

bool hasEqualNeighbors(const Outline& outline) {
  for (size_t i = 0; i < outline.size(); ++i) {
    if (outline[i] == outline[(i + 1) % outline.size()]) return true;
  }
  return false;
}

// Of a hundred thousand, in boxes of all shapes; in small ones corners are often in line, or on one another as they are
// seen.
TEST(WarpedPolygon, RandomOnesAreCutAsTheyAreSeenAlongTheirNormal) {
  constexpr int kTrials = 100'000;
  const std::array<std::array<int64_t, 3>, 5> boxes{
      {{1000, 1000, 1000}, {1000, 1000, 30}, {1000, 20, 30}, {4, 4, 4}, {1000, 1000, 1}}};
  Random random;
  int simple = 0, tried = 0;
  for (int trial = 0; trial < kTrials && !::testing::Test::HasFailure(); ++trial) {
    SCOPED_TRACE("trial " + std::to_string(trial));
    const size_t count = trial % 2 ? 4 : 6, axis = size_t(trial) % 3;
    Outline outline = trial % 4 < 2 ? random.anyOutline(count, boxes[size_t(trial / 4) % boxes.size()])
                                    : random.roundOutline(count, 1000, trial % 8 < 4 ? 1000 : 100, axis);
    if (hasEqualNeighbors(outline)) continue;
    if (trial % 16 < 4) {
      // Turned, so that no axis is the box's own.
      for (Vector& p : outline)
        p = {2 * p[0] - p[1] + 2 * p[2], 2 * p[0] + 2 * p[1] - p[2], -p[0] + 2 * p[1] + 2 * p[2]};
    }
    ++tried;
    simple += expectCut(outline);
  }
  EXPECT_GT(tried, kTrials * 9 / 10);
  EXPECT_GT(simple, kTrials / 2);
}

// Straight corners of a warped polygon are kept: a neighbour may use them.
TEST(WarpedPolygon, StraightCornersAreUsed) {
  Random random;
  for (int trial = 0; trial < 1000; ++trial) {
    Outline outline;
    for (const Vector& p : random.roundOutline(4, 1000, 700, size_t(trial) % 3))
      outline.push_back({2 * p[0], 2 * p[1], 2 * p[2]});
    const Vector &a = outline[0], &b = outline[1];
    outline.insert(outline.begin() + 1, {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2});
    std::rotate(outline.begin(), outline.begin() + trial % 5, outline.end());
    expectCut(outline);
  }
}

// Of any numbers: corners at one place, in line, very far, very near; without a crash, and all in the mesh unless there
// is no area.
TEST(WarpedPolygon, AnyCornersAreCut) {
  std::mt19937_64 random(2);
  const std::array<double, 9> numbers{0, 1, -1, 0.1, 1.0 / 3, 1e-17, 1e30, -1e-200, 5};
  for (int trial = 0; trial < 20'000; ++trial) {
    std::vector<glm::dvec3> corners(3 + random() % 10);
    for (glm::dvec3& corner : corners) {
      for (int k = 0; k < 3; ++k) {
        const double number = numbers[random() % numbers.size()];
        corner[k] = trial % 2 ? number : number * double(random() >> 11);
      }
    }
    const CutPolygon polygon = triangulatePolygon(corners);
    for (const auto& triangle : polygon.triangles) {
      for (const uint32_t corner : triangle) ASSERT_LT(corner, corners.size());
    }
    EXPECT_FALSE(polygon.crossesItself && polygon.triangles.empty());
  }
}

using Triangles = std::vector<std::array<uint32_t, 3>>;

Triangles cut(const std::vector<glm::dvec3>& corners) {
  const CutPolygon polygon = triangulatePolygon(corners);
  EXPECT_FALSE(polygon.crossesItself);
  return polygon.triangles;
}

// Along the axis closest to the normal, these lose a corner.
TEST(WarpedPolygon, ConvexOnesAreFansFromTheFirstCorner) {
  const Triangles fan{{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0}, {1, 0, 0.5}, {0, 1, 0}}), fan);
  EXPECT_EQ(cut({{0, 0, 0}, {0, 0, -2}, {1, 0, -1}, {0, -1, 0}}), fan);
  // There this one crosses itself; along its normal it is concave, with one way to cut it.
  EXPECT_EQ(cut({{0, 0, 0}, {35, 80, -11}, {28, 51, -7}, {-1, -23, -24}}), (Triangles{{0, 1, 2}, {3, 0, 2}}));
  // A saddle, and one that is warped by a hair.
  EXPECT_EQ(cut({{0, 0, 0}, {1, 0, 0.3}, {1, 1, 0}, {0, 1, 0.3}}), fan);
  EXPECT_EQ(cut({{0.1, 0.2, 0}, {1.1, 0, 1e-9}, {1, 1.3, 0}, {0, 1, 1e-9}}), fan);
}

TEST(WarpedPolygon, HolesAreKept) {
  std::vector<glm::dvec3> corners{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                  {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  for (glm::dvec3& corner : corners) corner.z = 0.05 * corner.x * corner.y;
  EXPECT_EQ(cut(corners).size(), 8u);
}

}  // namespace
}  // namespace turner
