#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <random>

#include "closed_form.h"
#include "errors.h"
#include "shader/pack.h"
#include "shader_harness.h"

namespace turner {
namespace {

Scene mixedScene() {
  Scene scene;
  scene.camera = {.eye = {100, 200, 300}, .target = {100, 200, 290}, .up = {0, 1, 0}, .fov = 40};
  scene.materials = {closed_form::matte({1, 0.5, 0.25}), closed_form::glass(0.1, 0.8, 1.5)};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-3, 3), size(0.01, 0.2);
  for (int i = 0; i < 300; ++i)
    scene.spheres.push_back(
        {{100 + place(random), 200 + place(random), 290 + place(random)}, size(random), uint32_t(i % 2)});
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 corner(100 + place(random), 200 + place(random), 290 + place(random));
    scene.triangles.push_back(
        {{corner, corner + glm::dvec3(size(random), 0, 0), corner + glm::dvec3(0, size(random), 0.1)},
         uint32_t(i % 2)});
  }
  return scene;
}

TEST(RoundScene, PutsTheEyeAtTheOriginAndTheTargetBetweenOneAndTwo) {
  for (const double distance : {1e-7, 0.3, 1.0, 1.999, 2.0, 10.0, 1e9}) {
    const LocalFrame frame = localFrame({.eye = {5, 6, 7}, .target = {5, 6, 7 - distance}});
    const double local = frame.scale * glm::length(glm::dvec3(5, 6, 7) - glm::dvec3(5, 6, 7 - distance));
    EXPECT_GE(local, 1);
    EXPECT_LT(local, 2);
    EXPECT_EQ(std::exp2(std::round(std::log2(frame.scale))), frame.scale) << "not a power of two";
  }
}

TEST(RoundScene, GivesValuesThatAreFloats) {
  const Scene local = roundScene(mixedScene());
  const auto isFloat = [](double x) { return double(float(x)) == x; };
  for (const Sphere& sphere : local.spheres) {
    EXPECT_TRUE(isFloat(sphere.radius));
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(isFloat(sphere.center[k]));
  }
  for (const Triangle& triangle : local.triangles)
    for (const glm::dvec3& vertex : triangle.vertices)
      for (int k = 0; k < 3; ++k) EXPECT_TRUE(isFloat(vertex[k]));
}

TEST(RoundScene, KeepsInverseSquareLight) {
  Scene scene = mixedScene();
  scene.lights.push_back({.position = {100, 200, 280}, .color = {3, 3, 3}, .falloff = Falloff::inverseSquare});
  const Scene local = roundScene(scene);
  const double scale = localFrame(scene.camera).scale, distance = 20 * scale;
  EXPECT_NEAR(local.lights[0].color.x / (distance * distance), 3.0 / 400, 1e-9);
}

TEST(RoundScene, RefusesWhatFloatsCannotHold) {
  const Scene scene = mixedScene();
  EXPECT_NO_THROW(checkReach(roundScene(scene)));
  Scene far = scene;
  far.spheres[7].center.x = 1e20;
  EXPECT_THROW(checkReach(roundScene(far)), InputError);
  far = scene;
  far.triangles[7].vertices[1].y = -1e29;
  EXPECT_THROW(checkReach(roundScene(far)), InputError);
  far = scene;
  far.camera.target = far.camera.eye + glm::dvec3(0, 0, -1e-10);
  EXPECT_THROW(checkReach(roundScene(far)), InputError);
  far = scene;
  far.lights.push_back({.position = {1e18, 0, 0}});
  EXPECT_THROW(checkReach(roundScene(far)), InputError);
}

TEST(Pack, RefusesATreeDeeperThanTheStack) {
  const Scene local = roundScene(mixedScene());
  Bvh bvh = buildBvh(primitiveBoxes(local), local.spheres.size());
  bvh.depth = int(gpu::kMaxTreeDepth) + 1;
  EXPECT_THROW(packScene(local, bvh), RunError);
}

TEST(Pack, EveryPrimitiveIsReachedOnceAndInItsLeafsBox) {
  const Scene scene = mixedScene();
  const Scene local = roundScene(scene);
  const PackedScene packed = test::packed(scene);
  ASSERT_EQ(packed.spheres.size(), 300u);
  ASSERT_EQ(packed.triangles.size(), 300u);
  std::vector<int> seen(600, 0);
  const auto inside = [](const glm::dvec3& p, const gpu::Row& lo, const gpu::Row& hi) {
    return p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x <= hi.x && p.y <= hi.y && p.z <= hi.z;
  };
  const auto visitLeaf = [&](gpu::uint reference, const gpu::Row& lo, const gpu::Row& hi) {
    const gpu::uint count = (reference >> gpu::kRefCountShift & gpu::kRefCountMask) + 1;
    for (gpu::uint i = reference & gpu::kRefIndexMask, end = i + count; i < end; ++i) {
      if (reference & gpu::kRefTriangle) {
        const gpu::uint id = packed.triangles.at(i).v0.w;
        ++seen.at(id);
        for (const glm::dvec3& vertex : local.triangles.at(id - 300).vertices) EXPECT_TRUE(inside(vertex, lo, hi));
        EXPECT_EQ(packed.triangles[i].v1.w, local.triangles[id - 300].material);
        EXPECT_EQ(packed.triangles[i].v2.w, gpu::kRefNone);
      } else {
        const gpu::uint id = std::bit_cast<gpu::uint>(packed.spheres.at(i).tags.x);
        ++seen.at(id);
        const Sphere& sphere = local.spheres.at(id);
        EXPECT_TRUE(inside(sphere.center - sphere.radius, lo, hi));
        EXPECT_TRUE(inside(sphere.center + sphere.radius, lo, hi));
        EXPECT_EQ(std::bit_cast<float>(packed.spheres[i].center.w), float(sphere.radius));
      }
    }
  };
  for (const gpu::Node& node : packed.nodes) {
    if (node.lo0.w & gpu::kRefLeaf) visitLeaf(node.lo0.w, node.lo0, node.hi0);
    if (node.hi0.w & gpu::kRefLeaf) visitLeaf(node.hi0.w, node.lo1, node.hi1);
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
}

TEST(Pack, AsksForNoMoreThanTheSceneNeeds) {
  Scene scene = mixedScene();
  Features features = test::packed(scene).features;
  EXPECT_TRUE(features.spheres && features.triangles && features.reflection && features.refraction);
  EXPECT_FALSE(features.highlights || features.smoothNormals || features.falloff);
  scene.spheres.clear();
  for (Triangle& triangle : scene.triangles) triangle.material = 0;
  features = test::packed(scene).features;
  EXPECT_FALSE(features.spheres || features.reflection || features.refraction) << "an unused material counts";
}

TEST(Pack, SumsOfTwoFloatsKeepTheCamera) {
  const Scene scene = mixedScene();
  const PackedScene packed = test::packed(scene);
  const gpu::Frame frame = packFrame(packed.view, test::settingsOf(scene, 640, 480), 1);
  const double tangent = std::tan(20 * closed_form::kDegree);
  EXPECT_NEAR(double(frame.rightHi.x) + double(frame.rightLo.x), 2 * tangent / 480, 1e-17);
  EXPECT_NEAR(double(frame.downHi.y) + double(frame.downLo.y), -2 * tangent / 480, 1e-17);
  EXPECT_EQ(double(frame.centreHi.z) + double(frame.centreLo.z), -1);
}

}  // namespace
}  // namespace turner
