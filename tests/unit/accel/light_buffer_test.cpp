// Lists of what rays through a point can hit: nothing is missing, nearest first, and no scene makes them huge. Rays
// look their lists up here as shaders/light_buffer.glsl does, in float; what they hit is computed in double.
#include "accel/light_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <set>
#include <type_traits>
#include <utility>

#include "gpu/pack_scene.h"
#include "support/random_numbers.h"

namespace turner {
namespace {

using glm::dvec3;
using gpu::uint;
using gpu::Word4;

using test::RandomNumbers;

dvec3 toFloat(const dvec3& v) {
  return {double(float(v.x)), double(float(v.y)), double(float(v.z))};
}

// What the lists are made over.
struct Listed {
  PreparedGeometry prepared;
  Bvh bvh;
  std::vector<uint> references;  // the place is the index in Bvh::order: that is enough here

  explicit Listed(Scene scene) {
    for (Sphere& sphere : scene.spheres) sphere.center = toFloat(sphere.center), sphere.radius = float(sphere.radius);
    for (Cone& cone : scene.cones) cone = toLocal(cone, LocalFrame{});
    for (dvec3& position : scene.positions) position = toFloat(position);
    prepared = prepareGeometry(std::move(scene));
    bvh = buildBvh(prepared.boxes, prepared.typeStarts());
    for (uint i = 0; i < bvh.order.size(); ++i) references.push_back(typeOf(bvh.order[i]) | i);
  }
  // Bits of a reference to an element.
  uint typeOf(size_t element) const {
    return element >= prepared.firstPair()            ? gpu::kRefTriangle
           : element >= prepared.scene.spheres.size() ? gpu::kRefCone
                                                      : 0;
  }
  LightBufferTree tree() const { return {prepared, bvh, references}; }
  TriangleCorners anyTriangle(RandomNumbers& random) const {
    return prepared.scene.cornersOf(random.index(prepared.scene.triangles.size()));
  }
};

LightBufferPoint pointAt(const dvec3& position, size_t rays, int walk = 0) {
  LightBufferPoint point;
  point.position = position;
  point.rays = rays;
  point.kernelTraversal = walk;
  return point;
}

struct Entry {
  uint reference;
  float distance;
};

Entry entryAt(const LightBuffers& lightBuffers, uint index) {
  const Word4& row = lightBuffers.rows.at(index / 2);
  return index % 2 ? Entry{row.z, std::bit_cast<float>(row.w)} : Entry{row.x, std::bit_cast<float>(row.y)};
}

// A quotient that is off by so many ulp: Vulkan allows a division 2.5.
float quotient(float a, float b, int ulps) {
  float result = a / b;
  for (; ulps > 0; --ulps) result = std::nextafterf(result, INFINITY);
  for (; ulps < 0; ++ulps) result = std::nextafterf(result, -INFINITY);
  return result;
}

// The list of a direction's cell, in the arithmetic of cellList().
struct List {
  int axis;
  uint first, end, triangles;
};

List listOf(const LightBuffers& lightBuffers, size_t point, const glm::vec3& d, int ulps = 0) {
  const glm::vec3 size = glm::abs(d);
  const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
  const float u = quotient(d[(axis + 1) % 3], d[axis], ulps), v = quotient(d[(axis + 2) % 3], d[axis], ulps);
  const auto face =
      std::bit_cast<gpu::LightBufferFace>(lightBuffers.rows.at(6 * point + 2 * size_t(axis) + (d[axis] < 0)));
  const uint side = face.cells & 255, firstCell = face.cells >> 8;
  const auto place = [&](float x, float corner) {
    return std::min(std::max((x - corner) * face.cellsPerUnit, 0.0f), float(side) - 0.001f);
  };
  const float x = place(u, face.corner.x), y = place(v, face.corner.y);
  const Word4& coarse = lightBuffers.rows.at(firstCell + uint(y) * side + uint(x));
  const uint fine = coarse.y;
  const auto within = [&](float p) { return uint((p - std::floor(p)) * float(fine)); };
  const Word4& cell = lightBuffers.rows.at(coarse.x + within(y) * fine + within(x));
  return {axis, cell.x, cell.y, cell.z};
}

constexpr double kMiss = std::numeric_limits<double>::infinity();

double distanceTo(const Sphere& sphere, const dvec3& origin, const dvec3& d) {
  const dvec3 f = origin - sphere.center;
  const double b = -glm::dot(f, d), squared = glm::dot(d, d);
  const dvec3 across = f + b / squared * d;
  const double rest = sphere.radius * sphere.radius - glm::dot(across, across);
  if (rest < 0) return kMiss;
  const double half = std::sqrt(rest * squared);
  return b - half > 0 ? (b - half) / squared : b + half > 0 ? (b + half) / squared : kMiss;
}

double distanceTo(const Cone& cone, const dvec3& origin, const dvec3& d) {
  const dvec3 way = cone.apex - cone.base, q = origin - cone.base;
  const double squared = glm::dot(way, way), s0 = glm::dot(q, way) / squared, s1 = glm::dot(d, way) / squared;
  const double radius = std::abs(cone.baseRadius), growth = std::abs(cone.apexRadius) - radius;
  const dvec3 y0 = q - s0 * way, y1 = d - s1 * way;
  const double r0 = radius + growth * s0, r1 = growth * s1;
  const double a = glm::dot(y1, y1) - r1 * r1, b = glm::dot(y0, y1) - r0 * r1, c = glm::dot(y0, y0) - r0 * r0;
  if (b * b < a * c) return kMiss;
  const double root = std::sqrt(b * b - a * c), sum = b < 0 ? root - b : -root - b;
  double nearest = kMiss;
  for (const double t : {c / sum, sum / a})
    if (t > 0 && s0 + t * s1 >= 0 && s0 + t * s1 <= 1) nearest = std::min(nearest, t);
  return nearest;
}

double distanceTo(const TriangleCorners& corners, const dvec3& origin, const dvec3& d) {
  const auto& [a, b, c] = corners;
  const dvec3 e1 = b - a, e2 = c - a, p = glm::cross(d, e2), s = origin - a, q = glm::cross(s, e1);
  const double det = glm::dot(p, e1), u = glm::dot(s, p) / det, v = glm::dot(d, q) / det;
  const double t = glm::dot(e2, q) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && t > 0 ? t : kMiss;
}

double distanceTo(const PreparedGeometry& prepared, const TrianglePair& pair, const dvec3& origin, const dvec3& d) {
  const double t = distanceTo(prepared.scene.cornersOf(pair.first), origin, d);
  return pair.isAlone() ? t : std::min(t, distanceTo(prepared.scene.cornersOf(pair.second), origin, d));
}

// To the nearest of a shape, by its box.
double distanceTo(const PreparedGeometry& prepared, uint box, const dvec3& origin, const dvec3& d) {
  return prepared.visitElement(box, [&](const auto& element) {
    if constexpr (std::is_same_v<std::decay_t<decltype(element)>, TrianglePair>)
      return distanceTo(prepared, element, origin, d);
    else
      return distanceTo(element, origin, d);
  });
}

// The shapes below a node, with the least distance that the list tells for them.
void collect(const Bvh& bvh, const BvhChild& child, float distance, std::vector<float>& found) {
  if (child.count == 0)
    for (const BvhChild& below : bvh.nodes[child.first].children) collect(bvh, below, distance, found);
  else
    for (uint i = child.first; i < child.first + child.count; ++i) found[i] = std::min(found[i], distance);
}

// Whatever a ray from the point hits must be in its list, and not be told to be farther than it is.
void expectHitsInList(const Listed& listed, const LightBuffers& lightBuffers, size_t index,
                      const LightBufferPoint& point, const glm::vec3& d) {
  for (const int ulps : {-2, 0, 2}) {
    const List list = listOf(lightBuffers, index, d, ulps);
    std::vector<float> found(listed.bvh.order.size(), INFINITY);
    for (uint i = list.first; i < list.end; ++i) {
      const Entry entry = entryAt(lightBuffers, i);
      const bool isPrimitive = entry.reference & gpu::kRefLeaf;
      const uint at = isPrimitive ? entry.reference & gpu::kRefOffsetMask : entry.reference;
      collect(listed.bvh, {{}, at, isPrimitive ? 1u : 0u}, entry.distance, found);
    }
    for (size_t i = 0; i < found.size(); ++i) {
      const uint box = listed.bvh.order[i];
      const double t = distanceTo(listed.prepared, box, point.position, d);
      if (t == kMiss) continue;
      ASSERT_NE(found[i], INFINITY) << "shape " << box << " is missing at t = " << t;
      ASSERT_LE(found[i], t * std::abs(d[list.axis]) * (1 + 0x1p-18)) << "shape " << box << " comes too late";
    }
  }
}

// Small and large, near and far, slivers among them; flat and folded pairs, some of whose corners do not stick out;
// cones from needles to discs.
Scene mixture(RandomNumbers& random, int count) {
  Scene scene;
  const double largest = random.size(0.05, 2);
  for (int i = 0; i < count / 3; ++i) {
    const double size = random.size(1e-4, largest);
    const dvec3 base = random.point(1);
    scene.cones.push_back({base, i % 3 == 0 ? 0 : size * random.size(1e-3, 1),
                           base + random.size(1e-2, 1) * size * glm::normalize(random.point(1)),
                           size * random.size(1e-3, 1), 0});
  }
  for (int i = 0; i < count; ++i) {
    const dvec3 at = random.point(1);
    const double size = random.size(1e-4, largest);
    if (i % 3 == 0) {
      scene.spheres.push_back({at, size, 0});
    } else {
      const dvec3 edge = random.point(size);
      const dvec3 other = i % 3 == 1 ? random.point(size) : random.between(0, 1) * edge + random.point(1e-5 * size);
      scene.addTriangle({at, at + edge, at + other}, 0);
      if (i % 2) scene.addTriangle({at + edge, at, at + (i % 4 == 1 ? edge - other : random.point(size))}, 0);
    }
  }
  return scene;
}

// A point of a cone, on one of its circles or between.
dvec3 onCone(const std::vector<Cone>& cones, RandomNumbers& random) {
  const Cone& cone = cones[random.index(cones.size())];
  const dvec3 way = glm::normalize(cone.apex - cone.base);
  const dvec3 across = glm::normalize(glm::cross(way, random.point(1)));
  const double share = std::array{0.0, 1.0, random.between(0, 1)}[random.index(3)];
  return glm::mix(cone.base, cone.apex, share) + std::lerp(cone.baseRadius, cone.apexRadius, share) * across;
}

TEST(LightBuffer, HoldsWhateverRaysHit) {
  RandomNumbers random{std::mt19937_64(7)};
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE("trial " + std::to_string(trial));
    const Listed listed(mixture(random, 3 + trial * 4));
    const TriangleCorners v = listed.anyTriangle(random);
    std::vector<LightBufferPoint> points;
    const size_t rays = size_t(1) << (8 + trial % 5 * 4);
    for (const dvec3& position : {random.point(1), random.point(4), dvec3(1e3, -400, 20), dvec3(-1e6, 3e5, 2e5),
                                  dvec3(0), v[0], (v[0] + v[1] + v[2]) / 3.0})
      points.push_back(pointAt(toFloat(position), rays));
    const LightBuffers lightBuffers = buildLightBuffers(points, listed.tree());
    for (size_t p = 0; p < points.size(); ++p) {
      for (int ray = 0; ray < 40; ++ray) {
        // Half of the rays go to a corner or an edge of something, where a cell ends most likely.
        const auto [a, b, c] = listed.anyTriangle(random);
        const double s = ray % 4 == 0 ? 0 : random.between(0, 1);
        dvec3 target = ray % 2 ? random.point(1) : s * a + (1 - s) * (ray % 3 ? b : c);
        if (ray % 8 == 6) target = onCone(listed.prepared.scene.cones, random);
        const glm::vec3 d = target - points[p].position;
        if (d != glm::vec3(0)) expectHitsInList(listed, lightBuffers, p, points[p], d);
        if (HasFatalFailure()) return;
      }
    }
  }
}

// Where cells are divided most, and where rays graze their borders and the diagonals of the cube.
TEST(LightBuffer, HoldsWhateverRaysAlongBordersOfCellsHit) {
  RandomNumbers random{std::mt19937_64(8)};
  const Listed listed(mixture(random, 120));
  const LightBufferPoint point = pointAt(toFloat(random.point(0.5)), size_t(1) << 24);
  const LightBuffers lightBuffers = buildLightBuffers(std::span(&point, 1), listed.tree());
  for (int ray = 0; ray < 4000; ++ray) {
    const auto coordinate = [&] {
      const float u = ray % 5 == 0 ? 1 : float(std::round(random.between(-4096, 4096)) / 4096);
      const float next = std::nextafterf(u, float(random.between(-2, 2)));
      return random.index(2) ? -next : next;
    };
    const float u = coordinate(), v = coordinate();
    const float sign = random.index(2) ? 1.0f : -1.0f;
    const glm::vec3 d = ray % 3 == 0   ? glm::vec3(sign, u, v)
                        : ray % 3 == 1 ? glm::vec3(v, sign, u)
                                       : glm::vec3(u, v, sign);
    expectHitsInList(listed, lightBuffers, 0, point, d);
    if (HasFatalFailure()) return;
  }
}

// Far away the boxes' padding is less than what a float can tell of u and v, and cells end where tiles do.
TEST(LightBuffer, HoldsWhateverRaysFromAfarHit) {
  RandomNumbers random{std::mt19937_64(13)};
  Scene scene;
  constexpr int kTiles = 32;
  const auto corner = [](int x, int y) { return dvec3(x * 2.0 / kTiles - 1, y * 2.0 / kTiles - 1, 0); };
  for (int y = 0; y < kTiles; ++y)
    for (int x = 0; x < kTiles; ++x) {
      scene.addTriangle({corner(x, y), corner(x + 1, y), corner(x + 1, y + 1)}, 0);
      scene.addTriangle({corner(x, y), corner(x + 1, y + 1), corner(x, y + 1)}, 0);
    }
  const Listed listed(std::move(scene));
  const LightBufferPoint point = pointAt({600, -500, 1000}, 1 << 22);
  const LightBuffers lightBuffers = buildLightBuffers(std::span(&point, 1), listed.tree());
  for (int ray = 0; ray < 4000; ++ray) {
    const dvec3 seam = corner(int(random.index(kTiles)), int(random.index(kTiles)));
    const dvec3 beside(random.between(-1, 1) * (ray % 2 ? 3e-5 : 0.01), random.between(-1, 1) * 3e-5, 0);
    expectHitsInList(listed, lightBuffers, 0, point, glm::vec3(seam + beside - point.position));
    if (HasFatalFailure()) return;
  }
}

// More shapes than lists open to the last: they keep nodes, and replace those that cover a cell.
TEST(LightBuffer, HoldsWhateverRaysHitOfALargeScene) {
  RandomNumbers random{std::mt19937_64(14)};
  Scene scene;
  constexpr int kTiles = 420;
  const auto corner = [&](int x, int y) {
    return dvec3(x * 2.0 / kTiles - 1, y * 2.0 / kTiles - 1, 0.02 * std::sin(0.3 * x) * std::sin(0.2 * y));
  };
  for (int y = 0; y < kTiles; ++y)
    for (int x = 0; x < kTiles; ++x) {
      scene.addTriangle({corner(x, y), corner(x + 1, y), corner(x + 1, y + 1)}, 0);
      scene.addTriangle({corner(x, y), corner(x + 1, y + 1), corner(x, y + 1)}, 0);
    }
  const Listed listed(std::move(scene));
  ASSERT_EQ(listed.prepared.pairs.size(), size_t(kTiles * kTiles));
  const std::vector<LightBufferPoint> points = {pointAt({0.5, -0.5, 2}, 1 << 16), pointAt({0.2, 0.3, 0.1}, 1 << 20)};
  const LightBuffers lightBuffers = buildLightBuffers(points, listed.tree());
  EXPECT_TRUE(lightBuffers.visitsNodes[0] && lightBuffers.visitsNodes[1]);
  for (int ray = 0; ray < 60; ++ray) {
    const dvec3 seam = corner(int(random.index(kTiles)), int(random.index(kTiles)));
    for (size_t p = 0; p < points.size(); ++p)
      expectHitsInList(listed, lightBuffers, p, points[p], glm::vec3(seam + random.point(1e-4) - points[p].position));
    if (HasFatalFailure()) return;
  }
}

// Every list that a row can lead to.
template <class Visit>
void forAllLists(const LightBuffers& lightBuffers, size_t points, const Visit& visit) {
  std::set<size_t> coarse;
  for (size_t f = 0; f < 6 * points; ++f) {
    const uint side = lightBuffers.rows.at(f).w & 255, first = lightBuffers.rows.at(f).w >> 8;
    for (uint i = 0; i < side * side; ++i) coarse.insert(first + i);
  }
  for (const size_t cell : coarse) {
    const uint first = lightBuffers.rows.at(cell).x, side = lightBuffers.rows.at(cell).y;
    for (uint i = 0; i < side * side; ++i) {
      const Word4& row = lightBuffers.rows.at(first + i);
      visit(row.x, row.y, row.z, row.w);
    }
  }
}

TEST(LightBuffer, ListsAreSortedSpheresFirstThenCones) {
  RandomNumbers random{std::mt19937_64(9)};
  for (const int count : {30, 3000}) {
    const Listed listed(mixture(random, count));
    const LightBufferPoint point = pointAt({3, 0, 1}, 1 << 16);
    const LightBuffers lightBuffers = buildLightBuffers(std::span(&point, 1), listed.tree());
    size_t lists = 0, nodes = 0;
    forAllLists(lightBuffers, 1, [&](uint first, uint end, uint triangles, uint cones) {
      ++lists;
      ASSERT_LE(first, end);
      ASSERT_LE(end, 2 * lightBuffers.rows.size());
      for (uint i = first; i < end; ++i) {
        const Entry entry = entryAt(lightBuffers, i);
        ASSERT_GE(entry.distance, 0);
        nodes += (entry.reference & gpu::kRefLeaf) == 0;
        if (i > first && (lightBuffers.visitsNodes[0] || (i != triangles && i != cones))) {
          ASSERT_LE(entryAt(lightBuffers, i - 1).distance, entry.distance);
        }
        if (!lightBuffers.visitsNodes[0]) {
          const uint type = listed.typeOf(listed.bvh.order[entry.reference & gpu::kRefOffsetMask]);
          ASSERT_EQ(type == gpu::kRefTriangle, i >= triangles);
          ASSERT_EQ(type == gpu::kRefCone, i >= cones && i < triangles);
          ASSERT_EQ(entry.reference & (gpu::kRefTriangle | (type == gpu::kRefTriangle ? 0 : gpu::kRefCone)), type);
        }
      }
    });
    EXPECT_GT(lists, 10u);
    if (!lightBuffers.visitsNodes[0]) {
      EXPECT_EQ(nodes, 0u);
    }
  }
}

TEST(LightBuffer, IsTheSameTwice) {
  RandomNumbers random{std::mt19937_64(10)};
  const Listed listed(mixture(random, 500));
  const std::vector<LightBufferPoint> points = {pointAt({0, 0, 3}, 1 << 16), pointAt({1, 2, 0}, 1 << 16, 1)};
  const LightBuffers a = buildLightBuffers(points, listed.tree()), b = buildLightBuffers(points, listed.tree());
  ASSERT_EQ(a.rows.size(), b.rows.size());
  EXPECT_EQ(0, std::memcmp(a.rows.data(), b.rows.data(), a.rows.size() * sizeof(Word4)));
  EXPECT_EQ(a.visitsNodes, b.visitsNodes);
}

TEST(LightBuffer, OfAnEmptySceneHasEmptyLists) {
  const Listed listed((Scene()));
  const std::vector<LightBufferPoint> points = {pointAt({0, 0, 0}, 100), pointAt({1, 2, 3}, 100, 1)};
  for (const LightBuffers& lightBuffers :
       {buildLightBuffers(points, listed.tree()), wholeTreeLightBuffers(points, listed.tree())}) {
    for (const glm::vec3& d : {glm::vec3(1, 0.5f, 0.2f), glm::vec3(-0.1f, -1, 0), glm::vec3(0, 0, 1e9f)}) {
      for (size_t p = 0; p < 2; ++p) {
        const List list = listOf(lightBuffers, p, d);
        EXPECT_EQ(list.first, list.end);
        EXPECT_NO_THROW(entryAt(lightBuffers, list.first));  // a walk looks at one before it compares
      }
    }
  }
}

// A light more costs less and less.
TEST(LightBuffer, ManyLightsStayBounded) {
  RandomNumbers random{std::mt19937_64(11)};
  const Listed listed(mixture(random, 150));
  std::vector<LightBufferPoint> points;
  for (int i = 0; i < 300; ++i) points.push_back(pointAt(toFloat(random.point(1)), 1 << 20));
  const LightBuffers lightBuffers = buildLightBuffers(points, listed.tree());
  EXPECT_LT(lightBuffers.rows.size() * sizeof(Word4), size_t(1) << 29);
}

// Where hundreds of triangles cross every cell, no division helps.
TEST(LightBuffer, PointAmongLargeTrianglesStaysBounded) {
  RandomNumbers random{std::mt19937_64(12)};
  Scene scene;
  for (int i = 0; i < 2500; ++i) {
    const dvec3 at = random.point(1);
    scene.addTriangle({at, at + random.point(1), at + random.point(1)}, 0);
  }
  const Listed listed(std::move(scene));
  LightBufferPoint point = pointAt({0, 0, 0}, 1 << 16);
  const LightBuffers lightBuffers = buildLightBuffers(std::span(&point, 1), listed.tree());
  EXPECT_LT(lightBuffers.rows.size() * sizeof(Word4), size_t(1) << 28);
}

}  // namespace
}  // namespace turner
