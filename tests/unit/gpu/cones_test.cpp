// Cones among spheres and triangles in the shader: the same picture however the work is cut and searched, and the
// reference's picture.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <random>
#include <string>

#include "image/compare.h"
#include "reference/reference.h"
#include "support/closed_form.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

using test::renderShader;
using test::settingsOf;

bool sameBits(const Image& a, const Image& b) {
  return a.window == b.window && a.rgb.size() == b.rgb.size() &&
         std::memcmp(a.rgb.data(), b.rgb.data(), a.rgb.size() * sizeof(float)) == 0;
}

struct Kinds {
  bool spheres, cones, triangles;
};

// All kinds mixed: needles, discs, tips, cylinders, some that face their axis; matte, mirrors and glass.
Scene mixedScene(const Kinds& kinds, int count, unsigned seed) {
  Scene scene;
  scene.camera = {.eye = {0, 0.5, 6}, .target = {0, 0, 0}, .fov = 40};
  scene.lights = {{.position = {3, 5, 4}}, {.position = {-4, 2, 1}, .color = {0.5, 0.4, 0.3}}};
  scene.background = {0.1, 0.2, 0.3};
  scene.materials = {closed_form::matte({0.8, 0.6, 0.4}), closed_form::mirror(0.5), closed_form::glass(0.1, 0.8, 1.3)};
  std::mt19937 random(seed);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const auto point = [&](double reach) {
    return glm::dvec3(between(-reach, reach), between(-reach, reach), between(-reach, reach));
  };
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 at = point(2), way = point(0.5), other = point(0.5);
    const double radius = between(0.02, 0.15), wide = std::exp(between(std::log(1e-3), std::log(0.4)));
    const uint32_t material = uint32_t(i % 3);
    if (i % 3 == 0 && kinds.spheres) scene.spheres.push_back({at, radius, material});
    if (i % 3 == 1 && kinds.triangles) scene.addTriangle({at, at + way, at + other}, material);
    if (i % 3 != 2 || !kinds.cones) continue;
    const double second = i % 4 == 0 ? 0 : i % 4 == 1 ? wide : between(0.02, 0.2), sign = i % 5 == 0 ? -1 : 1;
    const double length = i % 7 == 0 ? 0.02 : 1;
    scene.cones.push_back({at, sign * wide, at + length * way, sign * second, uint32_t(random() % 3)});
  }
  return scene;
}

class MixedScenes : public testing::TestWithParam<std::tuple<std::string, Kinds>> {};

// Lists, lists of nodes and walks from the root; interrupted everywhere, in the middle of a cell's list too.
TEST_P(MixedScenes, DoNotDependOnListsOrInterruptions) {
  const Scene scene = mixedScene(std::get<Kinds>(GetParam()), 240, 31);
  const RenderSettings settings = settingsOf(scene, 40, 30);
  const Image expected = renderShader(scene, settings);
  for (const TraversalStart start : {TraversalStart::lists, TraversalStart::mixedLists, TraversalStart::wholeTree}) {
    test::renderer().upload(test::packed(scene, settings, start));
    for (const uint32_t budget : {0u, kLeastBudget, 50u}) {
      Dispatching dispatching;
      if (budget > 0) dispatching.budget = budget;
      EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings, {}, dispatching).image, expected))
          << "start " << int(start) << ", in pieces of " << budget << " iterations";
    }
  }
}

// Without rays that walk the tree: the lists of eye and lights alone.
TEST_P(MixedScenes, OfMatteSurfacesDoNotDependOnInterruptions) {
  Scene scene = mixedScene(std::get<Kinds>(GetParam()), 240, 32);
  for (Material& material : scene.materials) material = closed_form::matte(glm::dvec3(0.3) + material.diffuse);
  const RenderSettings settings = settingsOf(scene, 40, 30);
  const PackedScene packed = test::packed(scene, settings);
  EXPECT_FALSE(packed.features.nearestNodes || packed.features.shadowNodes) << "the lists hold nodes";
  const Image expected = renderShader(scene, settings);
  for (const uint32_t budget : {kLeastBudget, 50u})
    EXPECT_TRUE(sameBits(renderShader(scene, settings, {.budget = budget}), expected)) << budget;
  test::renderer().upload(test::packed(scene, settings, TraversalStart::wholeTree));
  EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings).image, expected)) << "without lists";
}

TEST_P(MixedScenes, DoNotDependOnTheTree) {
  const Scene scene = mixedScene(std::get<Kinds>(GetParam()), 240, 33);
  const RenderSettings settings = settingsOf(scene, 40, 30);
  const Image expected = renderShader(scene, settings);
  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  test::renderer().upload(packScene(prepared, buildMedianBvh(prepared.boxes, prepared.typeStarts()), settings));
  EXPECT_TRUE(sameBits(test::renderer().render(test::kernel(), settings).image, expected));
}

// The reference's own tree loses nothing, and the shader sees what it sees.
TEST_P(MixedScenes, AgreeWithTheReference) {
  const Scene scene = mixedScene(std::get<Kinds>(GetParam()), 240, 34);
  RenderSettings settings = settingsOf(scene, 128, 96);
  settings.depth = 3;
  const ReferencePicture reference = renderReference(scene, settings);
  const ReferencePicture bruteForce = renderReference(scene, settings, {}, ReferenceSearch::bruteForce);
  EXPECT_TRUE(sameBits(reference.image, bruteForce.image)) << "the reference's tree";
  const Comparison c = compareImages(renderShader(scene, settings), reference.image, 1e-3);
  EXPECT_EQ(c.nan + c.inf, 0u);
  EXPECT_LE(c.badPixels, 0.003);
  EXPECT_LE(c.p99, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Render, MixedScenes,
                         testing::Values(std::tuple(std::string("ConesAlone"), Kinds{false, true, false}),
                                         std::tuple(std::string("SpheresAndCones"), Kinds{true, true, false}),
                                         std::tuple(std::string("ConesAndTriangles"), Kinds{false, true, true}),
                                         std::tuple(std::string("AllTypes"), Kinds{true, true, true})),
                         [](const auto& test) { return std::get<std::string>(test.param); });

// A ring of rods and balls, as SPD's rings: rods end in balls of their radius. Light falls on all of it as on one body.
TEST(Render, RodsAndBallsAgreeWithTheReference) {
  Scene scene;
  scene.camera = {.eye = {1.5, 3, 5}, .target = {0, 0, 0}, .fov = 40};
  scene.lights = {{.position = {3, 5, 4}}, {.position = {-4, 2, -1}, .color = {0.5, 0.4, 0.3}}};
  scene.materials = {closed_form::matte({0.8, 0.6, 0.4}), closed_form::mirror(0.4)};
  scene.materials[1].diffuse = {0.2, 0.5, 0.9};
  constexpr int kCount = 24;
  const auto corner = [](int i) {
    const double phi = 2 * M_PI * i / kCount;
    return glm::dvec3(1.5 * std::cos(phi), 0.3 * std::sin(3 * phi), 1.5 * std::sin(phi));
  };
  for (int i = 0; i < kCount; ++i) {
    scene.spheres.push_back({corner(i), 0.12, uint32_t(i % 2)});
    scene.cones.push_back({corner(i), 0.12, corner(i + 1), 0.12, uint32_t(i % 2)});
  }
  closed_form::addFloor(scene, -0.6, 6, 0);
  const RenderSettings settings = settingsOf(scene, 192, 144);
  const Comparison c = compareImages(renderShader(scene, settings), renderReference(scene, settings).image, 1e-3);
  EXPECT_LE(c.badPixels, 0.003);
  EXPECT_LE(c.p99, 1e-5);
}

// Rays across the axis exactly at a tip see it, shaded as the cone beside it. (Along the axis any normal of the tip is
// right, and the two have different ones.)
TEST(Render, TipsAreSeenAndShadedAlike) {
  for (const double radius : {0.02, 0.5, 2.0, 50.0}) {
    Scene scene;
    scene.camera = {.eye = {0, 0, 5}, .target = {0, 0, 0}, .fov = 1};
    scene.lights = {{.position = scene.camera.eye}};
    scene.materials = {closed_form::matte({1, 1, 1})};
    scene.cones = {{{0, -2, 0}, radius, {0, 0, 0}, 0, 0}};
    const RenderSettings settings = settingsOf(scene, 1, 1);
    const double cosine = 2 / std::hypot(radius, 2);
    EXPECT_NEAR(renderShader(scene, settings).rgb[0], cosine, 2e-6) << radius;
    EXPECT_NEAR(renderReference(scene, settings).image.rgb[0], cosine, 2e-6) << radius;
  }
}

}  // namespace
}  // namespace turner
