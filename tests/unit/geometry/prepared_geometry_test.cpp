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

// The square from 0 to 1, cut along its diagonal. `repeated`: each half has vertices of its own.
Scene square(bool repeated = true) {
  Scene scene;
  if (repeated) {
    scene.addTriangle({dvec3(0, 0, 0), dvec3(1, 0, 0), dvec3(1, 1, 0)});
    scene.addTriangle({dvec3(0, 0, 0), dvec3(1, 1, 0), dvec3(0, 1, 0)});
  } else {
    scene.positions = {dvec3(0, 0, 0), dvec3(1, 0, 0), dvec3(1, 1, 0), dvec3(0, 1, 0)};
    scene.triangles = {{.positions = {0, 1, 2}}, {.positions = {0, 2, 3}}};
  }
  return scene;
}

size_t pairCount(const Scene& scene) {
  return prepareGeometry(scene).pairs.size();
}

TEST(PreparedGeometry, TwoHalvesOfASquareAreAPair) {
  for (const bool repeated : {true, false}) {
    const PreparedGeometry prepared = prepareGeometry(square(repeated));
    ASSERT_EQ(prepared.pairs.size(), 1u);
    EXPECT_EQ(prepared.pairs[0].first, 0u);
    EXPECT_EQ(prepared.pairs[0].second, 1u);
    EXPECT_EQ(prepared.scene.cornersOf(0), (TriangleCorners{dvec3(1, 0, 0), dvec3(1, 1, 0), dvec3(0, 0, 0)}));
    EXPECT_EQ(prepared.scene.cornersOf(1), (TriangleCorners{dvec3(0, 1, 0), dvec3(0, 0, 0), dvec3(1, 1, 0)}));
    EXPECT_EQ(prepared.scene.positions, square(repeated).positions) << "what is shared was moved";
    for (int k = 0; k < 2; ++k) {
      EXPECT_LT(prepared.boxes[0].lo[k], 0);
      EXPECT_GT(prepared.boxes[0].hi[k], 1);
    }
  }
}

// Random triangles over shared vertices, and the same over vertices of their own: the same pairs, turned alike.
TEST(PreparedGeometry, PairsByIndexAreThoseByCoordinates) {
  std::mt19937 random(4);
  Scene shared, repeated;
  for (int i = 0; i < 40; ++i) shared.positions.emplace_back(random() % 4, random() % 4, random() % 4);
  for (int i = 0; i < 20'000; ++i) {
    const auto vertex = [&] { return uint32_t(random() % 40); };
    shared.triangles.push_back({.positions = {vertex(), vertex(), vertex()}, .material = uint32_t(i % 2)});
    repeated.addTriangle(shared.cornersOf(shared.triangles.back()), shared.triangles.back().material);
  }
  const PreparedGeometry byIndex = prepareGeometry(shared), byCoordinates = prepareGeometry(repeated);
  ASSERT_EQ(byIndex.pairs.size(), byCoordinates.pairs.size());
  EXPECT_LT(byIndex.pairs.size(), 19'000u) << "hardly any pairs: this tests nothing";
  for (size_t i = 0; i < byIndex.pairs.size(); ++i) {
    EXPECT_EQ(byIndex.pairs[i].first, byCoordinates.pairs[i].first);
    EXPECT_EQ(byIndex.pairs[i].second, byCoordinates.pairs[i].second);
  }
  for (size_t i = 0; i < shared.triangles.size(); ++i)
    EXPECT_EQ(byIndex.scene.cornersOf(i), byCoordinates.scene.cornersOf(i));
}

TEST(PreparedGeometry, NormalsTurnWithTheirCorners) {
  Scene scene = square();
  for (int i = 1; i <= 6; ++i) scene.normals.emplace_back(i, 0, 0);
  scene.triangles[0].normals = {0, 1, 2};
  scene.triangles[1].normals = {3, 4, 5};
  const PreparedGeometry prepared = prepareGeometry(scene);
  ASSERT_EQ(prepared.pairs.size(), 1u);
  EXPECT_EQ(prepared.scene.normalsOf(0), (TriangleCorners{dvec3(2, 0, 0), dvec3(3, 0, 0), dvec3(1, 0, 0)}));
  EXPECT_EQ(prepared.scene.normalsOf(1), (TriangleCorners{dvec3(6, 0, 0), dvec3(4, 0, 0), dvec3(5, 0, 0)}));
}

TEST(PreparedGeometry, WhatDiffersIsNoPair) {
  Scene scene = square();
  std::swap(scene.triangles[1].positions[1], scene.triangles[1].positions[2]);
  EXPECT_EQ(pairCount(scene), 2u) << "fronts on different sides";
  scene = square();
  scene.triangles[1].material = 1;
  EXPECT_EQ(pairCount(scene), 2u) << "different materials";
  scene = square();
  scene.normals = {dvec3(0, 0, 1)};
  scene.triangles[1].normals = {0, 0, 0};
  EXPECT_EQ(pairCount(scene), 2u) << "one is smooth, one is flat";
  scene = square();
  scene.positions[scene.triangles[1].positions[1]].z = 1e-9;
  EXPECT_EQ(pairCount(scene), 2u) << "an end of the edge is elsewhere";
  scene = square();
  scene.addTriangle({dvec3(5, 5, 5), dvec3(6, 5, 5), dvec3(5, 6, 5)});
  const Triangle apart = scene.triangles.back();
  scene.triangles.pop_back();
  scene.triangles.insert(scene.triangles.begin() + 1, 16, apart);
  EXPECT_EQ(pairCount(scene), 18u) << "too far apart in the scene";
}

// Two needles that share a short edge and point away from each other across a large box.
TEST(PreparedGeometry, WhatHasALargeBoxTogetherIsNoPair) {
  Scene scene;
  scene.addTriangle({dvec3(0, 0, 0), dvec3(0, 0, 0.01), dvec3(10, 0.01, 0)});
  scene.addTriangle({dvec3(0, 0, 0.01), dvec3(0, 0, 0), dvec3(0.01, 10, 0)});
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
    scene.addTriangle({corners[random() % 40], corners[random() % 40], corners[random() % 40]});
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
      for (const dvec3& vertex : scene.cornersOf(index)) {
        EXPECT_TRUE(glm::all(glm::lessThanEqual(dvec3(prepared.boxes[7 + i].lo), vertex)));
        EXPECT_TRUE(glm::all(glm::lessThanEqual(vertex, dvec3(prepared.boxes[7 + i].hi))));
      }
    };
    expectInBox(pair.first);
    if (pair.isAlone()) continue;
    ++seen.at(pair.second);
    expectInBox(pair.second);
    const TriangleCorners first = prepared.scene.cornersOf(pair.first), second = prepared.scene.cornersOf(pair.second);
    EXPECT_EQ(first[1], second[2]);
    EXPECT_EQ(first[2], second[1]);
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
}

}  // namespace
}  // namespace turner
