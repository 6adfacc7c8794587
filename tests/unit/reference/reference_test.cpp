// The reference against itself: tree against brute force, crop against picture, counts, and what must never happen.
// Its values are checked in closed_form_test.cpp.
#include "reference/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "reference/box_tree.h"
#include "support/closed_form.h"

namespace turner {
namespace {

using closed_form::addFloor;
using closed_form::addMaterial;
using closed_form::addQuad;
using closed_form::glass;
using closed_form::lookAt;
using closed_form::matte;
using closed_form::mirror;
using closed_form::pixels;
using glm::dvec3;

// Numbers that are the same with every standard library.
class Numbers {
 public:
  explicit Numbers(uint32_t seed) : engine(seed) {}
  double between(double low, double high) { return low + (high - low) * (double(engine()) * 0x1p-32); }
  dvec3 point(double size) {
    const double x = between(-size, size), y = between(-size, size);
    return {x, y, between(-size, size)};
  }

 private:
  std::mt19937 engine;
};

bool allFinite(const Image& image) {
  return std::all_of(image.rgb.begin(), image.rgb.end(), [](float value) { return std::isfinite(value); });
}

dvec3 colorAt(const Image& image, int x, int y) {
  const float* rgb =
      &image.rgb[3 * (size_t(y - image.window.y0) * size_t(image.window.width()) + size_t(x - image.window.x0))];
  return {rgb[0], rgb[1], rgb[2]};
}

void expectTreeFindsAll(const Scene& scene, const RenderSettings& settings) {
  const ReferencePicture tree = renderReference(scene, settings);
  const ReferencePicture brute = renderReference(scene, settings, {}, ReferenceSearch::bruteForce);
  EXPECT_EQ(tree.image.rgb, brute.image.rgb);
  EXPECT_EQ(tree.rays, brute.rays);
  EXPECT_TRUE(allFinite(tree.image));
}

// Matte, mirror and glass, spheres of both signs, flat and smooth triangles, small and large.
Scene mixedScene(uint32_t seed, int spheres, int triangles) {
  Numbers numbers(seed);
  Scene scene;
  scene.background = {0.2, 0.3, 0.4};
  scene.camera = lookAt(numbers.point(4) + dvec3(0, 0, 12), {0, 0, 0}, {0, 1, 0}, 50);
  scene.lights = {{.position = numbers.point(9), .color = {1, 0.8, 0.6}},
                  {.position = numbers.point(9), .color = {9, 9, 9}, .falloff = Falloff::inverseSquare}};
  addMaterial(scene, {.name = "shiny", .diffuse = {0.7, 0.5, 0.3}, .specular = dvec3(0.4), .shininess = 20});
  addMaterial(scene, mirror(0.6));
  addMaterial(scene, glass(0.2, 0.7, 1.5));
  for (int i = 0; i < spheres; ++i) {
    const double radius = numbers.between(0.05, i % 9 == 0 ? 2 : 0.5);
    scene.spheres.push_back({numbers.point(4), i % 5 == 0 ? -radius : radius, uint32_t(i % 3)});
  }
  for (int i = 0; i < triangles; ++i) {
    const dvec3 corner = numbers.point(4);
    const double size = i % 9 == 0 ? 4 : 0.5;
    const TriangleCorners corners{corner, corner + numbers.point(size), corner + numbers.point(size)};
    if (i % 2 == 0)
      scene.addTriangle(corners, {numbers.point(1), numbers.point(1), numbers.point(1)}, uint32_t(i % 3));
    else
      scene.addTriangle(corners, uint32_t(i % 3));
  }
  return scene;
}

// ---- Tree ----

TEST(Reference, TreeFindsWhatBruteForceFinds) {
  for (uint32_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    expectTreeFindsAll(mixedScene(seed, 60, 120), pixels(40, 30));
  }
}

TEST(Reference, TreeFindsWhatBruteForceFindsAmongFewPrimitives) {
  for (int count = 0; count <= 6; ++count) {
    SCOPED_TRACE(count);
    expectTreeFindsAll(mixedScene(uint32_t(100 + count), count, count), pixels(16, 16));
  }
}

TEST(Reference, TreeFindsWhatBruteForceFindsFarFromTheOrigin) {
  Scene scene = mixedScene(7, 40, 80);
  const dvec3 offset(148376, 1234, -223423);
  scene.camera.eye += offset;
  scene.camera.target += offset;
  for (Light& light : scene.lights) light.position += offset;
  for (Sphere& sphere : scene.spheres) sphere.center += offset;
  for (dvec3& position : scene.positions) position += offset;
  expectTreeFindsAll(scene, pixels(40, 30));
}

TEST(Reference, TreeTakesManyPrimitivesInOnePlace) {
  Scene scene = mixedScene(8, 0, 0);
  for (int i = 0; i < 700; ++i) scene.spheres.push_back({{0, 0, 0}, 1 + 1e-3 * i, uint32_t(i % 2)});
  for (int i = 0; i < 700; ++i) scene.addTriangle({dvec3(-4, -2, 2), dvec3(4, -2, 2), dvec3(0, 3, 2)}, uint32_t(i % 2));
  expectTreeFindsAll(scene, pixels(24, 24));
}

TEST(Reference, TreeTakesSizesInGeometricProgression) {
  Scene scene = mixedScene(9, 0, 0);
  for (int k = -40; k <= 40; ++k)
    scene.spheres.push_back({{std::ldexp(1.0, k), 0, 0}, std::ldexp(0.25, k), uint32_t(k & 1)});
  scene.camera = lookAt({0, 0.5, 3}, {1, 0, 0}, {0, 1, 0}, 60);
  expectTreeFindsAll(scene, pixels(32, 32));
}

// Rays along an axis, over a grid of flat boxes whose sides they run along: the slab test's 0 * infinity.
TEST(Reference, TreeTakesRaysAlongTheAxes) {
  for (int axis = 0; axis < 3; ++axis) {
    SCOPED_TRACE(axis);
    Scene scene;
    scene.background = {0.5, 0.5, 0.5};
    for (double color : {0.25, 0.75}) addMaterial(scene, matte(dvec3(color)));
    addMaterial(scene, mirror(1));
    dvec3 forward(0), right(0), up(0);
    forward[axis] = -1;
    right[(axis + 1) % 3] = 1;
    up[(axis + 2) % 3] = 1;
    for (int i = -4; i < 4; ++i)
      for (int j = -4; j < 4; ++j) {
        const dvec3 corner = double(i) * right + double(j) * up;
        addQuad(scene, corner, right, up, uint32_t((i + j) & 1));
        addQuad(scene, corner + 2.0 * forward, right, up, 2);  // and mirrors behind, facing the eye
      }
    // Behind every second square there is none, so that rays go on to the mirrors and come back.
    for (size_t k = 0; k < scene.triangles.size(); k += 16)
      scene.triangles[k].positions[1] = scene.triangles[k].positions[0];
    // A narrow picture: the middle column and row have direction components of zero.
    for (const dvec3& offset : {dvec3(0), 0.5 * right + 0.5 * up, right - up, 4.0 * right}) {
      scene.camera = lookAt(offset - 3.0 * forward, offset, up, 1e-9);
      scene.lights = {{.position = offset - 3.0 * forward}};
      expectTreeFindsAll(scene, pixels(3, 3));
      scene.camera.fov = 90;
      expectTreeFindsAll(scene, pixels(17, 17));
    }
  }
}

TEST(ReferenceTree, VisitsEveryBoxOnTheRayAndStopsWhenTold) {
  std::vector<reference::Box> boxes;
  for (int i = 0; i < 1000; ++i) boxes.push_back({dvec3(i, -1, -1), dvec3(i + 0.5, 1, 1)});
  const reference::BoxTree tree(boxes, 1e-12);
  std::vector<uint32_t> seen;
  tree.traverse({-1, 0, 0}, {1, 0, 0}, 1e9, [&](uint32_t i) {
    seen.push_back(i);
    return 1e9;
  });
  std::sort(seen.begin(), seen.end());
  ASSERT_EQ(seen.size(), 1000u);
  for (uint32_t i = 0; i < 1000; ++i) EXPECT_EQ(seen[i], i);

  int visits = 0;
  tree.traverse({-1, 0, 0}, {1, 0, 0}, 1e9, [&](uint32_t) {
    ++visits;
    return -1.0;
  });
  EXPECT_LE(visits, 4);  // one leaf
}

TEST(TimingReferenceTree, TakesAMillionBoxesInSeconds) {
  Numbers numbers(1);
  std::vector<reference::Box> boxes;
  for (int i = 0; i < 1'000'000; ++i) {
    const dvec3 low = numbers.point(100);
    boxes.push_back({low, low + 0.1});
  }
  const Stopwatch watch;
  const reference::BoxTree tree(boxes, 0);
  const double seconds = watch.seconds();
  RecordProperty("seconds", std::to_string(seconds));
  // It takes about one; the bound only catches quadratic work, also under a sanitizer on a busy machine.
  EXPECT_LT(seconds, 120);
}

// ---- Watertight, exact and free of acne ----

// A sphere of triangles around the eye, mirrored by octants: rays at its vertices and edges must not escape.
TEST(Reference, NoRayLeaksThroughAMesh) {
  // An octahedron, each face cut in four, four times.
  std::vector<std::array<dvec3, 3>> faces;
  for (double x : {-1.0, 1.0})
    for (double y : {-1.0, 1.0})
      for (double z : {-1.0, 1.0}) faces.push_back({dvec3(x, 0, 0), dvec3(0, y, 0), dvec3(0, 0, z)});
  for (int level = 0; level < 4; ++level) {
    std::vector<std::array<dvec3, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const dvec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
      for (const auto& face : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}}) finer.push_back(face);
    }
    faces = std::move(finer);
  }
  Scene scene;
  scene.background = dvec3(1);
  const uint32_t black = addMaterial(scene, matte(dvec3(0)));
  const dvec3 centre(1234.5, -77.25, 1e4);
  for (const auto& [a, b, c] : faces) scene.addTriangle({centre + a, centre + b, centre + c}, black);

  // Aim at vertices and at points of edges, from a point off the centre. One pixel is one ray, along the view axis.
  Numbers numbers(2);
  for (int ray = 0; ray < 6000; ++ray) {
    const TriangleCorners face = scene.cornersOf(size_t(ray) * 7 % scene.triangles.size());
    const double along = ray % 3 == 0 ? 0 : ray % 3 == 1 ? 0.5 : numbers.between(0, 1);
    const dvec3 target = face[size_t(ray) % 3] + along * (face[size_t(ray + 1) % 3] - face[size_t(ray) % 3]);
    scene.camera = lookAt(centre + numbers.point(0.3), target, {0.1, 1, 0.2}, 45);
    // The search for a leak needs no tree, and a new one for each ray would take long.
    scene.camera.fov = 1;
    const Image image = renderReference(scene, pixels(1, 1), {}, ReferenceSearch::bruteForce).image;
    ASSERT_EQ(image.rgb[0], 0) << "ray " << ray;
  }
}

// A floor of small cells under a light that is almost level with it: no cell shadows its neighbour.
TEST(Reference, AFlatMeshCastsNoShadowOnItself) {
  for (double size : {1e-3, 1.0, 1e3}) {
    Scene scene;
    const uint32_t white = addMaterial(scene, matte(dvec3(1)));
    // Tilted, so that the plane is not exact in its coordinates.
    const dvec3 across = size * glm::normalize(dvec3(1, 0.3, 0.2));
    const dvec3 normal = glm::normalize(glm::cross(dvec3(-0.1, 0.2, 1), across));
    const dvec3 along = glm::cross(across, normal);
    const auto vertex = [&](int i, int j) { return double(i) * across + double(j) * along; };
    for (int i = -16; i < 16; ++i)
      for (int j = -16; j < 16; ++j) {
        scene.addTriangle({vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1)}, white);
        scene.addTriangle({vertex(i, j), vertex(i + 1, j + 1), vertex(i + 1, j)}, white);
      }
    // Pixels are half a cell apart, so that three quarters of them see edges or vertices.
    scene.camera =
        lookAt(20 * size * normal, {0, 0, 0}, across, 2 / closed_form::kDegree * std::atan(0.5 * 61 / 2 / 20));
    scene.lights = {{.position = 1000.0 * across + 0.2 * size * normal}};
    const Image image = renderReference(scene, pixels(61, 61)).image;
    int dark = 0;
    for (float value : image.rgb) dark += value <= 0;
    EXPECT_EQ(dark, 0) << "cells of " << size;
  }
}

// The eye at height h over a ground sphere of radius 10^6 looks down at 45 degrees: the light above the point where it
// hits tells how exact that point is.
TEST(Reference, SeesAGiantSphereFromNearby) {
  for (double h : {1.0, 1.3e-2, 1.3e-4, 1.7e-6}) {
    Scene scene;
    scene.camera = lookAt({0, h, 0}, {h, 0, 0}, {0, 1, 0}, 1);
    scene.spheres.push_back({{0, -1e6, 0}, 1e6, addMaterial(scene, matte(dvec3(1)))});
    scene.lights = {{.position = {h, 0.5 * h, 0}}, {.position = {1.5 * h, 0.5 * h, 0}}};
    const Image image = renderReference(scene, pixels(1, 1)).image;
    EXPECT_NEAR(image.rgb[0], 1 + std::sqrt(0.5), 2e-6) << "height " << h;
  }
}

TEST(Reference, CoincidentSpheresAreLitAsOne) {
  Scene scene;
  scene.camera = lookAt({0.3, 0.2, 4}, {0, 0, 0}, {0, 1, 0}, 45);
  scene.lights = {{.position = {3, 2, 4}}};
  scene.spheres.push_back({{0.1, 0.2, 0.3}, 1, addMaterial(scene, matte({0.5, 0.25, 1}))});
  const Image one = renderReference(scene, pixels(33, 33)).image;
  for (int copy = 0; copy < 3; ++copy)
    scene.spheres.push_back({{0.1, 0.2, 0.3}, 1, addMaterial(scene, matte({1, 0, 0}))});
  EXPECT_EQ(renderReference(scene, pixels(33, 33)).image.rgb, one.rgb);
}

// A matte sphere under 10^-6 of glass: the ray that enters the glass must find it.
TEST(Reference, FindsASurfaceCloseBehindAnother) {
  Scene scene;
  scene.camera = lookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 20);
  scene.lights = {{.position = {0, 0, 4}}};
  scene.spheres.push_back({{0, 0, 0}, 1, addMaterial(scene, glass(0, 1, 1.5))});
  scene.spheres.push_back({{0, 0, 0}, 1 - 1e-6, addMaterial(scene, matte(dvec3(1)))});
  const ReferencePicture picture = renderReference(scene, pixels(9, 9));
  EXPECT_EQ(picture.rays.refracted, 81u);
  EXPECT_EQ(picture.rays.shadow, 81u);                        // the matte sphere was reached everywhere ...
  for (float value : picture.image.rgb) EXPECT_EQ(value, 0);  // ... and is in the shadow of its glass
}

// ---- Samples, crops, seeds ----

TEST(Reference, CropEqualsThatPartOfThePicture) {
  const Scene scene = mixedScene(11, 40, 60);
  RenderSettings settings = pixels(45, 37);
  settings.samples = 2;
  settings.sampler = Sampler::jitter;
  const Image whole = renderReference(scene, settings).image;
  for (const Window& crop : {Window{7, 5, 31, 30}, Window{44, 36, 45, 37}, Window{0, 17, 45, 18}}) {
    settings.crop = crop;
    const Image part = renderReference(scene, settings).image;
    EXPECT_EQ(part.width, 45);
    EXPECT_EQ(part.height, 37);
    ASSERT_EQ(part.window, crop);
    for (int y = crop.y0; y < crop.y1; ++y)
      for (int x = crop.x0; x < crop.x1; ++x) ASSERT_EQ(colorAt(part, x, y), colorAt(whole, x, y)) << x << ' ' << y;
  }
}

TEST(Reference, RepeatsItselfBitForBit) {
  const Scene scene = mixedScene(12, 40, 60);
  RenderSettings settings = pixels(64, 48);
  settings.samples = 3;
  settings.sampler = Sampler::jitter;
  settings.seed = 5;
  const ReferencePicture first = renderReference(scene, settings);
  for (int run = 0; run < 3; ++run) {
    const ReferencePicture again = renderReference(scene, settings);
    EXPECT_EQ(again.image.rgb, first.image.rgb);
    EXPECT_EQ(again.rays, first.rays);
  }
}

TEST(Reference, RowsAddUpToThePicture) {
  const Scene scene = mixedScene(13, 40, 60);
  RenderSettings settings = pixels(33, 20);
  const ReferencePicture whole = renderReference(scene, settings);
  RayCounts sum;
  std::vector<float> rgb;
  for (int y = 0; y < 20; ++y) {
    settings.crop = {0, y, 33, y + 1};
    const ReferencePicture row = renderReference(scene, settings);
    rgb.insert(rgb.end(), row.image.rgb.begin(), row.image.rgb.end());
    sum.eye += row.rays.eye;
    sum.reflected += row.rays.reflected;
    sum.refracted += row.rays.refracted;
    sum.shadow += row.rays.shadow;
  }
  EXPECT_EQ(rgb, whole.image.rgb);
  EXPECT_EQ(sum, whole.rays);
}

// Stripes as wide as half a cell: a sample's position decides its colour.
Scene halfCellStripes(int n, int width) {
  Scene scene;
  scene.background = dvec3(1);
  scene.camera = lookAt({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90);
  const uint32_t black = addMaterial(scene, matte(dvec3(0)));
  const double stripe = 2.0 / width / n / 2;  // the picture reaches from -1 to 1
  for (int i = 0; i < width * n; ++i) addQuad(scene, {-1 + 2 * stripe * i, -2, 0}, {stripe, 0, 0}, {0, 4, 0}, black);
  return scene;
}

TEST(Reference, JitterDependsOnTheSeedAndTheGridDoesNot) {
  const Scene scene = halfCellStripes(4, 8);
  RenderSettings settings = pixels(8, 8);
  settings.samples = 4;
  settings.sampler = Sampler::jitter;
  settings.seed = 1;
  const Image one = renderReference(scene, settings).image;
  settings.seed = 2;
  const Image two = renderReference(scene, settings).image;
  EXPECT_NE(one.rgb, two.rgb);
  // Half of the 1024 samples, give or take: each falls on its cell's black half with probability 1/2.
  for (const Image& image : {one, two}) {
    double mean = 0;
    for (float value : image.rgb) mean += value / double(image.rgb.size());
    EXPECT_NEAR(mean, 0.5, 5 * 0.5 / 32);
  }

  settings.sampler = Sampler::grid;
  const Image grid = renderReference(scene, settings).image;
  settings.seed = 1;
  EXPECT_EQ(renderReference(scene, settings).image.rgb, grid.rgb);
}

// Every second column, then every second row of cells is black: as each sample stays in its cell, half of them are.
TEST(Reference, JitterStaysInItsCell) {
  constexpr int n = 5, width = 2;
  for (bool columns : {true, false}) {
    Scene scene;
    scene.background = dvec3(1);
    scene.camera = lookAt({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90);
    const uint32_t black = addMaterial(scene, matte(dvec3(0)));
    const double cell = 2.0 / (width * n);
    for (int i = 0; i < width * n; i += 2) {
      const double low = -1 + cell * i;
      if (columns)
        addQuad(scene, {low, -2, 0}, {cell, 0, 0}, {0, 4, 0}, black);
      else
        addQuad(scene, {-2, low, 0}, {4, 0, 0}, {0, cell, 0}, black);
    }
    RenderSettings settings = pixels(width, width);
    settings.samples = n;
    settings.sampler = Sampler::jitter;
    for (settings.seed = 0; settings.seed < 50; ++settings.seed) {
      const Image image = renderReference(scene, settings, {}, ReferenceSearch::bruteForce).image;
      for (int y = 0; y < width; ++y)
        for (int x = 0; x < width; ++x) {
          // 5 cells to a pixel: black are 3 of them in the first pixel from the left or from below, 2 in the second.
          const bool first = columns ? x == 0 : y == 1;
          ASSERT_EQ(float(colorAt(image, x, y).x), first ? 0.4f : 0.6f) << "seed " << settings.seed;
        }
    }
  }
}

// ---- Counts ----

RayCounts count(const Scene& scene, const RenderSettings& settings) {
  return renderReference(scene, settings).rays;
}

// One ray straight down on a horizontal square of this material, under two lights above it and one below.
Scene squareUnderLights(const Material& material) {
  Scene scene;
  scene.camera = lookAt({0, 2, 0}, {0, 0, 0}, {0, 0, -1}, 45);
  scene.lights = {{.position = {3, 4, 0}}, {.position = {-3, 4, 0}}, {.position = {0, -4, 0}}};
  addFloor(scene, 0, 5, addMaterial(scene, material));
  return scene;
}

TEST(Reference, CountsShadowRaysTowardLightsAboveTheSurface) {
  EXPECT_EQ(count(squareUnderLights(matte(dvec3(1))), pixels(3, 2)), (RayCounts{.eye = 6, .shadow = 12}));
}

TEST(Reference, CountsNoShadowRayFromWhatLightsCannotChange) {
  EXPECT_EQ(count(squareUnderLights(matte(dvec3(0))), pixels(1, 1)), RayCounts{.eye = 1});
  Material clear = glass(0.5, 0.5, 1.5);
  clear.diffuse = dvec3(1);
  // w_local is 0. The reflected and the refracted ray leave the scene.
  EXPECT_EQ(count(squareUnderLights(clear), pixels(1, 1)), (RayCounts{.eye = 1, .reflected = 1, .refracted = 1}));
}

TEST(Reference, CountsNoRayOfWeightZero) {
  Material material = mirror(1);
  EXPECT_EQ(count(squareUnderLights(material), pixels(1, 1)), (RayCounts{.eye = 1, .reflected = 1}));
  EXPECT_EQ(count(squareUnderLights(glass(0, 1, 1.5)), pixels(1, 1)), (RayCounts{.eye = 1, .refracted = 1}));
}

TEST(Reference, CountsSamples) {
  RenderSettings settings = pixels(4, 3);
  settings.samples = 5;
  settings.crop = {1, 1, 3, 3};
  EXPECT_EQ(count({}, settings), RayCounts{.eye = 100});
}

// A glass sphere hit along its axis: in, out, and at each surface also a reflected ray.
TEST(Reference, CountsTheRayTreeOfAGlassSphere) {
  Scene scene;
  scene.camera = lookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45);
  scene.spheres.push_back({{0, 0, 0}, 1, addMaterial(scene, glass(0.25, 0.75, 1.5))});
  // Inside, each level has one ray, which spawns one that stays inside (reflected) and one that leaves (refracted).
  EXPECT_EQ(count(scene, pixels(1, 1, 1)), (RayCounts{.eye = 1}));
  EXPECT_EQ(count(scene, pixels(1, 1, 2)), (RayCounts{.eye = 1, .reflected = 1, .refracted = 1}));
  EXPECT_EQ(count(scene, pixels(1, 1, 3)), (RayCounts{.eye = 1, .reflected = 2, .refracted = 2}));
  EXPECT_EQ(count(scene, pixels(1, 1, 5)), (RayCounts{.eye = 1, .reflected = 4, .refracted = 4}));
}

// Total internal reflection spawns one ray, a reflected one.
TEST(Reference, CountsOneRayOnTotalReflection) {
  Scene scene;
  scene.camera = lookAt({0, -1, 0}, {2, 0, 0}, {0, 1, 0}, 45);
  addFloor(scene, 0, 9, addMaterial(scene, glass(0, 0.75, 1.5)));
  EXPECT_EQ(count(scene, pixels(1, 1)), (RayCounts{.eye = 1, .reflected = 1}));
}

// A smooth normal that would send a leaving ray back to the viewer's side: d 70 degrees and -Ns 38 degrees off the axis
// put T at 38 + asin(1.5 sin 32) = 90.6 degrees. About Ng the angle is above the critical one.
TEST(Reference, TransmissionToTheWrongSideIsReflectedInFull) {
  const double degree = closed_form::kDegree;
  Scene scene = closed_form::tiltedNormals(0, glass(0.25, 0.75, 1.5));
  scene.normals.assign(3, {std::sin(38 * degree), 0, -std::cos(38 * degree)});
  scene.camera = lookAt({-2 * std::sin(70 * degree), 0, 2 * std::cos(70 * degree)}, {0, 0, 0}, {0, 1, 0}, 45);
  EXPECT_EQ(count(scene, pixels(1, 1)), (RayCounts{.eye = 1, .reflected = 1}));
}

// A corridor of mirrors with r = 1/2: the ray of level k has weight 2^(1-k).
TEST(Reference, DropsRaysBelowTheLeastWeight) {
  Scene scene;
  scene.camera = lookAt({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 45);
  const uint32_t material = addMaterial(scene, mirror(0.5));
  addQuad(scene, {-3, -5, -1}, {7, 0, 0}, {0, 9, 0}, material);
  addQuad(scene, {-3, -5, 1}, {0, 9, 0}, {7, 0, 0}, material);
  RenderSettings settings = pixels(1, 1, 64);
  EXPECT_EQ(count(scene, settings), (RayCounts{.eye = 1, .reflected = 63}));
  settings.minWeight = 0.125f;
  EXPECT_EQ(count(scene, settings), (RayCounts{.eye = 1, .reflected = 3}));
  settings.minWeight = 0.13f;
  EXPECT_EQ(count(scene, settings), (RayCounts{.eye = 1, .reflected = 2}));
}

// An NFF material may weigh more than 1 in all: its lights count in full beside its mirrored ray.
TEST(Reference, TakesTheLocalWeightAsItStands) {
  Scene scene = squareUnderLights({.name = "nff", .diffuse = dvec3(1), .reflect = 0.75, .localWeight = 1});
  scene.background = dvec3(1);
  EXPECT_NEAR(renderReference(scene, pixels(1, 1)).image.rgb[0], 0.75 + 2 * 0.8, 1e-6);
}

// ---- What must never happen ----

TEST(Reference, EmptySceneIsBackground) {
  Scene scene;
  scene.background = {0.25, 0.5, 1};
  for (auto search : {ReferenceSearch::tree, ReferenceSearch::bruteForce}) {
    const Image image = renderReference(scene, pixels(20, 20), {}, search).image;
    for (size_t i = 0; i < image.rgb.size(); i += 3) {
      EXPECT_EQ(image.rgb[i], 0.25f);
      EXPECT_EQ(image.rgb[i + 1], 0.5f);
      EXPECT_EQ(image.rgb[i + 2], 1.0f);
    }
  }
}

TEST(Reference, WithoutLightsObjectsAreBlack) {
  Scene scene = squareUnderLights(matte(dvec3(1)));
  scene.lights.clear();
  const ReferencePicture picture = renderReference(scene, pixels(4, 4));
  for (float value : picture.image.rgb) EXPECT_EQ(value, 0);
  EXPECT_EQ(picture.rays, RayCounts{.eye = 16});
}

// A light on the plane that it shines on, at the point that the middle pixel sees, and inside surfaces.
TEST(Reference, ALightOnASurfaceGivesNoNaN) {
  for (Falloff falloff : {Falloff::none, Falloff::inverseSquare})
    for (double tilt : {0.0, 0.3}) {
      Scene scene;
      const uint32_t shiny =
          addMaterial(scene, {.name = "shiny", .diffuse = dvec3(1), .specular = dvec3(1), .shininess = 9});
      const dvec3 across = glm::normalize(dvec3(1, tilt, tilt)),
                  normal = glm::normalize(glm::cross(across, dvec3(0, tilt, 1)));
      const dvec3 along = glm::cross(across, normal);
      addQuad(scene, -3.1 * across - 2.9 * along, 7.0 * along, 7.0 * across, shiny);
      scene.camera = lookAt(-2.0 * normal, {0, 0, 0}, across, 45);
      scene.lights = {{.position = {0, 0, 0}, .color = dvec3(1), .falloff = falloff}};
      const Image image = renderReference(scene, pixels(21, 21)).image;
      for (float value : image.rgb) ASSERT_EQ(value, 0) << "tilt " << tilt;
    }
  // On a sphere: no point of it sees the light.
  Scene scene;
  scene.camera = lookAt({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 40);
  scene.lights = {{.position = {0, 0, 1}, .color = dvec3(1), .falloff = Falloff::inverseSquare}};
  scene.spheres.push_back({{0, 0, 0}, 1, addMaterial(scene, matte(dvec3(1)))});
  for (float value : renderReference(scene, pixels(21, 21)).image.rgb) ASSERT_EQ(value, 0);
}

// The surface that a light lies on does not keep its light from others: a lamp on the ceiling.
TEST(Reference, ALightOnTheCeilingLightsTheFloor) {
  Scene scene = squareUnderLights(matte(dvec3(1)));
  scene.lights = {{.position = {0.4, 3, 0.3}}};
  const Image open = renderReference(scene, pixels(15, 15)).image;
  addQuad(scene, {-9, 3, -8}, {17, 0, 0}, {0, 0, 17}, 0);
  EXPECT_EQ(renderReference(scene, pixels(15, 15)).image.rgb, open.rgb);
}

TEST(Reference, TrianglesWithoutAreaAreInvisible) {
  Scene scene = mixedScene(14, 10, 30);
  const Image clean = renderReference(scene, pixels(32, 32)).image;
  const dvec3 a(0.5, 0.25, 3), b(1, 0.25, 3);
  scene.addTriangle({a, a, a}, 0);
  scene.addTriangle({a, a, b}, 0);
  scene.addTriangle({a, 0.5 * (a + b), b}, 0);
  EXPECT_EQ(renderReference(scene, pixels(32, 32)).image.rgb, clean.rgb);
}

TEST(Reference, AnEmptyCropIsAnEmptyPicture) {
  RenderSettings settings = pixels(8, 8);
  settings.crop = {3, 3, 3, 3};
  EXPECT_TRUE(renderReference({}, settings).image.rgb.empty());
}

// ---- Progress ----

TEST(Reference, ProgressRisesFromNothingToAll) {
  std::vector<double> shares;
  renderReference(mixedScene(15, 20, 20), pixels(64, 64), [&](double share) { shares.push_back(share); });
  ASSERT_GE(shares.size(), 2u);
  EXPECT_EQ(shares.front(), 0);
  EXPECT_EQ(shares.back(), 1);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
}

// A picture of hours: two mirrors of glass face each other, 2^64 rays to a sample.
void stopPictureOfHours() {
  Scene scene;
  scene.camera = lookAt({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 1);
  const uint32_t material = addMaterial(scene, glass(0.5, 0.5, 1.5));
  for (int k = 0; k < 9; ++k) {
    addQuad(scene, {-3, -5, -1.0 - k}, {7, 0, 0}, {0, 9, 0}, material);
    addQuad(scene, {-3, -5, 1.0 + k}, {0, 9, 0}, {7, 0, 0}, material);
  }
  int calls = 0;
  EXPECT_THROW(renderReference(scene, pixels(100, 100, 64),
                               [&](double) {
                                 if (++calls == 3) throw Interrupted();
                               }),
               Interrupted);
  EXPECT_EQ(calls, 3);
}

TEST(Reference, ProgressThatThrowsStopsTheRendering) {
  stopPictureOfHours();
}

TEST(TimingReference, ProgressThatThrowsStopsTheRenderingSoon) {
  const Stopwatch watch;
  stopPictureOfHours();
  const double seconds = watch.seconds();
  EXPECT_LT(seconds, 20);
}

}  // namespace
}  // namespace turner
