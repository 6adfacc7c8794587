// A cone on the host: its box, its picture on the faces of a cube, and what of it is kept where it is rounded.
#include "primitives/cone.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/prepared_geometry.h"
#include "layout.h"
#include "support/random_numbers.h"

namespace turner {
namespace {

using glm::dvec3;
using glm::vec3;

using test::RandomNumbers;

// Thin, flat, with tips, cylinders, some along an axis of the frame.
Cone randomCone(RandomNumbers& random, double reach) {
  Cone cone;
  cone.base = dvec3(vec3(random.point(reach)));
  dvec3 way = random.point(1);
  const size_t axis = random.engine() % 6;
  if (axis < 3) way = dvec3(0), way[int(axis)] = 1;
  const double length = random.size(1e-2, 1);
  cone.apex = cone.base + length * glm::normalize(way);
  cone.baseRadius = length * random.size(1e-3, 1e3);
  cone.apexRadius = std::array{0.0, cone.baseRadius, length * random.size(1e-3, 10)}[random.engine() % 3];
  if (random.engine() % 2) std::swap(cone.baseRadius, cone.apexRadius);
  if (random.engine() % 8 == 0) cone.baseRadius = -cone.baseRadius, cone.apexRadius = -cone.apexRadius;
  return cone;
}

double widest(const Cone& cone) {
  return std::max(std::abs(cone.baseRadius), std::abs(cone.apexRadius));
}

// Two unit vectors across its axis.
std::array<dvec3, 2> across(const Cone& cone) {
  const dvec3 axis = glm::normalize(cone.apex - cone.base);
  const dvec3 a = glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.5 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  return {a, glm::cross(axis, a)};
}

dvec3 onCone(const Cone& cone, const std::array<dvec3, 2>& basis, double share, double angle) {
  const double radius = std::abs(cone.baseRadius) + share * (std::abs(cone.apexRadius) - std::abs(cone.baseRadius));
  return cone.base + share * (cone.apex - cone.base) +
         radius * (std::cos(angle) * basis[0] + std::sin(angle) * basis[1]);
}

double area(const FaceRect& r) {
  return double(r.uHi - r.uLo) * double(r.vHi - r.vLo);
}

// --- the box ---

TEST(Cone, BoundsHoldItsSurfaceTightly) {
  RandomNumbers random{std::mt19937_64(1)};
  double slack = 0;
  for (int i = 0; i < 400; ++i) {
    const Cone cone = randomCone(random, 3);
    const auto basis = across(cone);
    const Bounds bounds = boundsOf(cone);
    Bounds surface;
    for (int k = 0; k < 250; ++k)
      surface.include(onCone(cone, basis, random.between(0, 1), random.between(0, 2 * M_PI)));
    // Where a circle reaches farthest along an axis.
    for (const double share : {0.0, 1.0})
      for (int axis = 0; axis < 3; ++axis) {
        const double angle = std::atan2(basis[1][axis], basis[0][axis]);
        surface.include(onCone(cone, basis, share, angle));
        surface.include(onCone(cone, basis, share, angle + M_PI));
      }
    const double rounding = 4e-16 * (4 + widest(cone));
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(bounds.lo[axis], surface.lo[axis] + rounding);
      EXPECT_GE(bounds.hi[axis], surface.hi[axis] - rounding);
      slack = std::max({slack, (surface.lo[axis] - bounds.lo[axis]) / widest(cone),
                        (bounds.hi[axis] - surface.hi[axis]) / widest(cone)});
    }
  }
  EXPECT_LE(slack, 1e-6);
}

// --- its picture on a face ---

// Of points on a plane, by Andrew's monotone chain.
double areaOfHull(std::vector<glm::dvec2> points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  const auto turn = [](const glm::dvec2& o, const glm::dvec2& a, const glm::dvec2& b) {
    return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
  };
  std::vector<glm::dvec2> hull;
  for (int side = 0; side < 2; ++side) {
    const size_t begin = hull.size();
    for (const glm::dvec2& p : points) {
      while (hull.size() >= begin + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  double twice = 0;
  for (size_t i = 0; i < hull.size(); ++i) {
    const glm::dvec2 &a = hull[i], &b = hull[(i + 1) % hull.size()];
    twice += a.x * b.y - a.y * b.x;
  }
  return 0.5 * std::abs(twice);
}

// Of the part of a rectangle on the positive sides of the edges.
double areaInEdges(const FaceRect& r, const OuterEdges& edges) {
  std::vector<glm::dvec2> polygon = {{r.uLo, r.vLo}, {r.uHi, r.vLo}, {r.uHi, r.vHi}, {r.uLo, r.vHi}};
  for (const vec3& edge : edges) {
    if (edge == vec3(0)) continue;
    const auto side = [&](const glm::dvec2& p) { return double(edge.x) * p.x + double(edge.y) * p.y + double(edge.z); };
    std::vector<glm::dvec2> cut;
    for (size_t i = 0; i < polygon.size(); ++i) {
      const glm::dvec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      if (side(a) >= 0) cut.push_back(a);
      if ((side(a) >= 0) != (side(b) >= 0)) cut.push_back(a + side(a) / (side(a) - side(b)) * (b - a));
    }
    polygon = cut;
  }
  return polygon.size() < 3 ? 0 : areaOfHull(polygon);
}

TEST(Cone, PictureHoldsItsSurfaceTightly) {
  RandomNumbers random{std::mt19937_64(2)};
  double ofRects = 0, ofEdges = 0, ofHulls = 0, ofBoxes = 0;
  size_t pictures = 0, behind = 0;
  for (int i = 0; i < 1500; ++i) {
    const Cone cone = randomCone(random, 2);
    Scene scene;
    scene.cones = {cone};
    const Box box = prepareGeometry(scene).boxes.at(0);
    const CubeFace face(dvec3(vec3(random.point(random.engine() % 2 ? 4 : 40))), int(random.engine() % 6));
    const auto basis = across(cone);
    Projection projection{};
    if (!face.project(box, projection)) continue;
    const Projection ofBox = projection;
    OuterEdges edges{};
    narrow(cone, face, box, projection, edges);
    EXPECT_EQ(projection.distance, ofBox.distance);
    // The whole cone is before the point, or nothing has changed.
    double nearest = INFINITY;
    for (const double share : {0.0, 1.0})
      for (int k = 0; k < 64; ++k) nearest = std::min(nearest, face.seen(onCone(cone, basis, share, k * M_PI / 32)).z);
    if (nearest <= 0) {
      ++behind;
      EXPECT_EQ(0, std::memcmp(&projection.rect, &ofBox.rect, sizeof(FaceRect)));
      EXPECT_EQ(edges, OuterEdges{});
      continue;
    }
    std::vector<glm::dvec2> seen;
    for (int k = 0; k < 400; ++k) {
      // Circles alone decide on the hull.
      const double share = k < 240 ? double(k % 2) : random.between(0, 1);
      const dvec3 p = face.seen(onCone(cone, basis, share, k < 240 ? k * M_PI / 120 : random.between(0, 2 * M_PI)));
      const glm::dvec2 at(p.x / p.z, p.y / p.z);
      seen.push_back(at);
      const FaceRect& r = projection.rect;
      if (std::max(std::abs(at.x), std::abs(at.y)) > 1) continue;  // off the face
      EXPECT_TRUE(at.x >= r.uLo && at.x <= r.uHi && at.y >= r.vLo && at.y <= r.vHi)
          << "cone " << i << ", point " << k << " is outside of the rectangle";
      for (const vec3& edge : edges)
        EXPECT_GE(double(edge.x) * at.x + double(edge.y) * at.y + double(edge.z), 0) << "cone " << i << ", point " << k;
      if (HasFailure()) return;
    }
    // As far as a face reaches.
    if (std::max(-projection.rect.uLo, projection.rect.uHi) > 1 ||
        std::max(-projection.rect.vLo, projection.rect.vHi) > 1)
      continue;
    ++pictures;
    ofHulls += areaOfHull(seen);
    ofRects += area(projection.rect);
    ofEdges += areaInEdges(projection.rect, edges);
    ofBoxes += area(ofBox.rect);
  }
  EXPECT_GT(pictures, 150u);
  EXPECT_GT(behind, 50u);
  RecordProperty("areas", "to the hull's: rectangle " + std::to_string(ofRects / ofHulls) + ", with edges " +
                              std::to_string(ofEdges / ofHulls) + ", box " + std::to_string(ofBoxes / ofHulls));
  EXPECT_LE(ofEdges / ofHulls, 1.15);
}

// --- what is kept where it is rounded ---

constexpr LocalFrame kFrame{{0.3, -0.7, 0.11}, 4};

TEST(Cone, RoundedEndsAreTheSpheresAndNeighbours) {
  RandomNumbers random{std::mt19937_64(3)};
  for (int i = 0; i < 1000; ++i) {
    const dvec3 joint = random.point(1), other = random.point(1), beyond = random.point(1);
    const double radius = random.size(1e-3, 0.1);
    const Cone first = toLocal(Cone{other, random.size(1e-3, 0.1), joint, radius, 0}, kFrame);
    const Cone second = toLocal(Cone{joint, radius, beyond, random.size(1e-3, 0.1), 0}, kFrame);
    const Sphere ball = toLocal(Sphere{joint, radius, 0}, kFrame);
    if (glm::length(other - joint) < 0.2 || glm::length(beyond - joint) < 0.2) continue;
    EXPECT_EQ(first.apex, second.base);
    EXPECT_EQ(first.apexRadius, second.baseRadius);
    EXPECT_EQ(ball.center, first.apex);
    EXPECT_EQ(dvec3(vec3(first.apex)), first.apex);
    EXPECT_EQ(dvec3(vec3(first.base)), first.base);
    EXPECT_EQ(double(float(first.apexRadius)), first.apexRadius);
  }
}

TEST(Cone, FlatOnesKeepTheirAxes) {
  RandomNumbers random{std::mt19937_64(4)};
  for (int i = 0; i < 1000; ++i) {
    Cone flat{random.point(1), 0.3, {}, 0.5, 0};
    const dvec3 way = random.size(1e-5, 0.1) * glm::normalize(random.point(1));
    flat.apex = flat.base + way;
    if (i % 2) std::swap(flat.baseRadius, flat.apexRadius);
    const Cone local = toLocal(flat, kFrame);
    // To the last digits, though ends that are rounded to float32 would tilt it by 1e-7 over its length.
    EXPECT_LE(glm::length((local.apex - local.base) / 4.0 - way), 4e-16);
    // The anchor, the end of the lesser radius, is float32's.
    const dvec3 anchor = i % 2 ? local.apex : local.base;
    EXPECT_EQ(dvec3(vec3(anchor)), anchor);
  }
}

// Ends that are one float apart or none at all still have a length.
TEST(Cone, EndsThatRoundToOnePointStayApart) {
  const Cone tiny{{0.1, 0.2, 0.3}, 1e-9, {0.1 + 1e-10, 0.2, 0.3}, 1e-9, 0};
  const Cone local = toLocal(tiny, {{0, 0, 0}, 1});
  EXPECT_NE(local.base, local.apex);
  EXPECT_NEAR((local.apex - local.base).x, 1e-10, 1e-16);
}

TEST(Cone, PackedFromTheLesserRadius) {
  Cone cone{{1, 2, 3}, 2, {1, 2, 7}, 1, 5};
  for (int turn = 0; turn < 2; ++turn) {
    const gpu::Cone form = packed(cone, 9);
    EXPECT_EQ(form.anchor.z, turn == 0 ? 7 : 3);
    EXPECT_EQ(form.axis.z, turn == 0 ? -1 : 1);
    EXPECT_EQ(form.span, 4);
    EXPECT_EQ(form.base, float(4 / std::sqrt(17.0)));
    EXPECT_EQ(form.slope, float(1 / std::sqrt(17.0)));
    EXPECT_EQ(form.squaredCosine, float(16 / 17.0));
    EXPECT_GE(form.reach, std::sqrt(20.0));
    EXPECT_LE(form.reach, std::sqrt(20.0) * (1 + 1e-5));
    EXPECT_EQ(form.rank, 9u);
    EXPECT_EQ(form.material, 5u);
    cone = {cone.base, cone.apexRadius, cone.apex, cone.baseRadius, cone.material};
  }
  EXPECT_EQ(packed(Cone{{0, 0, 1}, -1, {0, 0, 2}, 0, 5}, 0).material, 5u | gpu::kConeInward);
  EXPECT_EQ(packed(Cone{{0, 0, 1}, 1e-4, {0, 0, 2}, 0, 5}, 0).material, 5u | gpu::kFarCone);
}

// Shorter than a double beside it can tell, or than its square can be: seen as nothing, and still with an axis.
TEST(Cone, KeepsAnAxisHoweverShort) {
  const LocalFrame frame{{0, 1, 4}, 0.25};
  for (const double length : {1e-14, 1e-17, 1e-200, 1e-310})
    for (const auto& [base, apex] : {std::pair(0.5, 0.5), {1e4 * length, 1e4 * length}, {0.0, length}, {length, 0.0}}) {
      const Cone world{{0, 0, 0}, base, {0, 0, length}, apex};
      EXPECT_FALSE(isTooFlat(world));
      EXPECT_TRUE(std::isfinite(boundsOf(world).lo.x + boundsOf(world).hi.z));
      const Cone local = toLocal(world, frame);
      EXPECT_GT(local.apex.z, local.base.z) << length;
      EXPECT_LT(local.apex.z - local.base.z, 1e-12);
      const gpu::Cone form = packed(local, 0);
      EXPECT_EQ(std::abs(form.axis.z), 1);
      EXPECT_TRUE(std::isfinite(form.base + form.span + form.reach + form.slope + form.squaredCosine));
    }
}

TEST(Cone, IsFarBeyondManyRadii) {
  const auto isFar = [](double radius, double from, double to) {
    return isFarFromEye(Cone{{0, 0, from}, radius, {0, 0, to}, 0.5 * radius, 0});
  };
  EXPECT_FALSE(isFar(1, 1000, 1023));
  EXPECT_TRUE(isFar(1, 1000, 1025));
  EXPECT_TRUE(isFar(1, -1025, 0));
  EXPECT_TRUE(isFar(-1e-3, 1, 2));
  EXPECT_FALSE(isFar(1e-3, 0.5, 1));
}

TEST(Cone, SlopeIsTheSineOfItsSide) {
  EXPECT_EQ(slopeOf(Cone{{0, 0, 0}, 2, {0, 0, 1}, 2, 0}), 0);
  EXPECT_DOUBLE_EQ(slopeOf(Cone{{0, 0, 0}, 3, {0, 4, 0}, 0, 0}), 0.6);
  EXPECT_DOUBLE_EQ(slopeOf(Cone{{0, 0, 0}, 0, {0, 4, 0}, -3, 0}), 0.6);
  EXPECT_NEAR(slopeOf(Cone{{0, 0, 0}, 1e5, {0, 0, 1}, 0, 0}), 1 - 0.5e-10, 1e-15);
}

TEST(Cone, IsTooFlatWhereItsRadiiDifferTooMuch) {
  const auto isFlat = [](double from, double to) { return isTooFlat(Cone{{0, 0, 0}, from, {0, 0, 1}, to, 0}); };
  EXPECT_FALSE(isFlat(0, kFlattestCone));
  EXPECT_TRUE(isFlat(0, 1.001 * kFlattestCone));
  EXPECT_TRUE(isFlat(1.001 * kFlattestCone, 0));
  EXPECT_TRUE(isFlat(0, -1.001 * kFlattestCone));
  EXPECT_FALSE(isFlat(1e9, 1e9));
}

TEST(Cone, IsWithinReachOfFloat) {
  EXPECT_TRUE(isWithinReach(Cone{{0, 0, 0}, 1e9, {0, 0, 1e9}, 1, 0}));
  EXPECT_FALSE(isWithinReach(Cone{{0, 0, 0}, 1e11, {0, 0, 1e9}, 1, 0}));
  EXPECT_FALSE(isWithinReach(Cone{{0, 0, 0}, -1, {0, 0, 1}, -1e11, 0}));
  EXPECT_FALSE(isWithinReach(Cone{{0, 0, 0}, 1, {0, 0, 1e11}, 1, 0}));
  EXPECT_FALSE(isWithinReach(Cone{{NAN, 0, 0}, 1, {0, 0, 1}, 1, 0}));
}

}  // namespace
}  // namespace turner
