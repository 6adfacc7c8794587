// Pairs of triangles: every triangle is in one, and what a pair shares is shared.
#include "geometry/prepared_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <random>

namespace turner {
namespace {

using glm::dvec3;

Triangle triangle(const dvec3& a, const dvec3& b, const dvec3& c, uint32_t material = 0) {
  return {{a, b, c}, material};
}

// The square from 0 to 1, cut along its diagonal.
Scene square() {
  Scene scene;
  scene.triangles = {triangle({0, 0, 0}, {1, 0, 0}, {1, 1, 0}), triangle({0, 0, 0}, {1, 1, 0}, {0, 1, 0})};
  return scene;
}

size_t pairCount(const Scene& scene) {
  return prepareGeometry(scene).pairs.size();
}

TEST(PreparedGeometry, TwoHalvesOfASquareAreAPair) {
  const PreparedGeometry prepared = prepareGeometry(square());
  ASSERT_EQ(prepared.pairs.size(), 1u);
  EXPECT_EQ(prepared.pairs[0].first, 0u);
  EXPECT_EQ(prepared.pairs[0].second, 1u);
  const auto& first = prepared.scene.triangles[0].vertices;
  const auto& second = prepared.scene.triangles[1].vertices;
  EXPECT_EQ(first, (std::array<dvec3, 3>{dvec3(1, 0, 0), dvec3(1, 1, 0), dvec3(0, 0, 0)}));
  EXPECT_EQ(second, (std::array<dvec3, 3>{dvec3(0, 1, 0), dvec3(0, 0, 0), dvec3(1, 1, 0)}));
  for (int k = 0; k < 2; ++k) {
    EXPECT_LT(prepared.boxes[0].lo[k], 0);
    EXPECT_GT(prepared.boxes[0].hi[k], 1);
  }
}

TEST(PreparedGeometry, NormalsTurnWithTheirCorners) {
  Scene scene = square();
  scene.normals = {{dvec3(1, 0, 0), dvec3(2, 0, 0), dvec3(3, 0, 0)}, {dvec3(4, 0, 0), dvec3(5, 0, 0), dvec3(6, 0, 0)}};
  scene.triangles[0].normals = 0;
  scene.triangles[1].normals = 1;
  const PreparedGeometry prepared = prepareGeometry(scene);
  ASSERT_EQ(prepared.pairs.size(), 1u);
  EXPECT_EQ(prepared.scene.normals[0], (std::array<dvec3, 3>{dvec3(2, 0, 0), dvec3(3, 0, 0), dvec3(1, 0, 0)}));
  EXPECT_EQ(prepared.scene.normals[1], (std::array<dvec3, 3>{dvec3(6, 0, 0), dvec3(4, 0, 0), dvec3(5, 0, 0)}));
}

TEST(PreparedGeometry, WhatDiffersIsNoPair) {
  Scene scene = square();
  std::swap(scene.triangles[1].vertices[1], scene.triangles[1].vertices[2]);
  EXPECT_EQ(pairCount(scene), 2u) << "fronts on different sides";
  scene = square();
  scene.triangles[1].material = 1;
  EXPECT_EQ(pairCount(scene), 2u) << "different materials";
  scene = square();
  scene.normals = {{dvec3(0, 0, 1), dvec3(0, 0, 1), dvec3(0, 0, 1)}};
  scene.triangles[1].normals = 0;
  EXPECT_EQ(pairCount(scene), 2u) << "one is smooth, one is flat";
  scene = square();
  scene.triangles[1].vertices[1].z = 1e-9;
  EXPECT_EQ(pairCount(scene), 2u) << "an end of the edge is elsewhere";
  scene = square();
  scene.triangles.insert(scene.triangles.begin() + 1, 16, triangle({5, 5, 5}, {6, 5, 5}, {5, 6, 5}));
  EXPECT_EQ(pairCount(scene), 18u) << "too far apart in the scene";
}

// Two needles that share a short edge and point away from each other across a large box.
TEST(PreparedGeometry, WhatHasALargeBoxTogetherIsNoPair) {
  Scene scene;
  scene.triangles = {triangle({0, 0, 0}, {0, 0, 0.01}, {10, 0.01, 0}),
                     triangle({0, 0, 0.01}, {0, 0, 0}, {0.01, 10, 0})};
  EXPECT_EQ(pairCount(scene), 2u);
}

// Degenerate, coincident and many-sided ones included.
TEST(PreparedGeometry, EveryTriangleIsInOnePair) {
  std::mt19937 random(3);
  Scene scene;
  scene.spheres.resize(7);
  std::vector<dvec3> corners;
  for (int i = 0; i < 40; ++i) corners.emplace_back(random() % 4, random() % 4, random() % 4);
  for (int i = 0; i < 60'000; ++i)
    scene.triangles.push_back(triangle(corners[random() % 40], corners[random() % 40], corners[random() % 40]));
  const PreparedGeometry prepared = prepareGeometry(scene);
  EXPECT_EQ(prepared.firstPair(), 7u);
  ASSERT_EQ(prepared.boxes.size(), 7 + prepared.pairs.size());
  EXPECT_LT(prepared.pairs.size(), 58'000u) << "hardly any pairs: this tests nothing";
  std::vector<int> seen(scene.triangles.size());
  uint32_t last = 0;
  for (size_t i = 0; i < prepared.pairs.size(); ++i) {
    const TrianglePair& pair = prepared.pairs[i];
    EXPECT_GE(pair.first, last);
    last = pair.first;
    ++seen.at(pair.first);
    const auto expectInBox = [&](uint32_t index) {
      for (const dvec3& vertex : scene.triangles[index].vertices) {
        EXPECT_TRUE(glm::all(glm::lessThanEqual(dvec3(prepared.boxes[7 + i].lo), vertex)));
        EXPECT_TRUE(glm::all(glm::lessThanEqual(vertex, dvec3(prepared.boxes[7 + i].hi))));
      }
    };
    expectInBox(pair.first);
    if (pair.isAlone()) continue;
    ++seen.at(pair.second);
    expectInBox(pair.second);
    const auto& first = prepared.scene.triangles[pair.first].vertices;
    const auto& second = prepared.scene.triangles[pair.second].vertices;
    EXPECT_EQ(first[1], second[2]);
    EXPECT_EQ(first[2], second[1]);
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
}

}  // namespace
}  // namespace turner
