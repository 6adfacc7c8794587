// The benchmark's procedural meshes: of the size that is asked for, without gaps, and facing outward.
#include "support/bumpy_spheres.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <tuple>

namespace turner::test {
namespace {

TEST(BumpySpheres, HaveAboutAsManyTrianglesAsAskedFor) {
  for (const double wanted : {1e3, 1e4, 1e5, 1e6}) {
    const double found = double(bumpySpheres(size_t(wanted)).triangles.size());
    EXPECT_NEAR(found, wanted, 0.05 * wanted);
  }
}

// Every edge of a closed surface is walked once in each direction; vertices count as one where their coordinates agree
// to the last bit. The floor alone has a rim, of four edges.
TEST(BumpySpheres, AreClosed) {
  using Point = std::tuple<double, double, double>;
  std::map<std::pair<Point, Point>, int> edges;
  const Scene scene = bumpySpheres(1000);
  for (size_t triangle = 0; triangle < scene.triangles.size(); ++triangle)
    for (size_t k = 0; k < 3; ++k) {
      const auto point = [&](size_t i) {
        const glm::dvec3 v = scene.cornersOf(triangle)[i % 3];
        return Point(v.x, v.y, v.z);
      };
      ++edges[{point(k), point(k + 1)}];
    }
  int open = 0;
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    open += int(!edges.contains({edge.second, edge.first}));
  }
  EXPECT_EQ(open, 4);
}

// The volume of a closed surface, by the signs of its faces: that of five balls with bumps.
TEST(BumpySpheres, FaceOutward) {
  double volume = 0;
  const Scene scene = bumpySpheres(10'000);
  for (const Triangle& triangle : scene.triangles) {
    const TriangleCorners v = scene.cornersOf(triangle);
    volume += glm::dot(v[0], glm::cross(v[1], v[2])) / 6;
  }
  double most = 0, least = 0;
  for (const double radius : {1.0, 0.8, 0.85, 0.5, 0.45}) {
    const double ball = 4.0 / 3.0 * M_PI * std::pow(radius, 3);
    least += 0.85 * std::pow(0.9, 3) * ball;  // where the noise is 0, and cells cut corners
    most += std::pow(1.05, 3) * ball;
  }
  EXPECT_GT(volume, least);
  EXPECT_LT(volume, most);
}

TEST(BumpySpheres, HaveTheSameShapeAtEverySize) {
  // A point of the coarse lattice is one of the fine lattice too: 4 cells and 12 to a side.
  const BumpyMesh coarse = bumpyMesh(960), fine = bumpyMesh(8640);
  double farthest = 0;
  for (const glm::dvec3& a : coarse.positions) {
    double nearest = INFINITY;
    for (const glm::dvec3& b : fine.positions) nearest = std::min(nearest, glm::distance(a, b));
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, 1e-12);
}

}  // namespace
}  // namespace turner::test
