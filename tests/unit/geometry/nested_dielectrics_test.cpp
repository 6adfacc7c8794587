// Solids of glass: which surfaces make one, which of them meet, and which of two is seen.
#include "geometry/nested_dielectrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "geometry/round_scene.h"
#include "reference/reference.h"
#include "support/closed_form.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

using closed_form::addQuad, closed_form::glass;
using glm::dvec3;
using std::vector;

constexpr uint32_t kGlass = 0, kWater = 1, kMatte = 2, kOtherGlass = 3;

Scene emptyScene() {
  Scene scene;
  scene.camera = {.eye = {0, 0, 20}, .target = {0, 0, 0}};
  scene.materials = {glass(0, 1, 1.5), glass(0, 1, 1.25), closed_form::matte({1, 1, 1}), glass(0, 1, 1.5)};
  return scene;
}

Scene ballsScene(const vector<Sphere>& spheres) {
  Scene scene = emptyScene();
  scene.spheres = spheres;
  return scene;
}

// Twelve triangles; x, y and z are the edges at a corner, right-handed. `inward`: their fronts are inside.
void addParallelepiped(Scene& scene, const dvec3& corner, const dvec3& x, const dvec3& y, const dvec3& z,
                       uint32_t material, bool inward = false) {
  const auto side = [&](const dvec3& at, const dvec3& a, const dvec3& b) {
    if (inward)
      addQuad(scene, at, b, a, material);
    else
      addQuad(scene, at, a, b, material);
  };
  side(corner, y, x), side(corner + z, x, y), side(corner, x, z), side(corner + y, z, x), side(corner, z, y),
      side(corner + x, y, z);
}

void addBox(Scene& scene, const dvec3& lo, const dvec3& hi, uint32_t material, bool inward = false) {
  const dvec3 size = hi - lo;
  addParallelepiped(scene, lo, {size.x, 0, 0}, {0, size.y, 0}, {0, 0, size.z}, material, inward);
}

size_t solidsOf(const Scene& scene) {
  return findNestedDielectrics(scene).materials.size();
}

TEST(NestedDielectrics, ApartThereIsNothingToSay) {
  EXPECT_EQ(solidsOf(ballsScene({{{-2, 0, 0}, 1, kGlass}, {{2, 0, 0}, 1, kWater}})), 0u);
  EXPECT_EQ(solidsOf(ballsScene({{{-1, 0, 0}, 1, kGlass}, {{1, 0, 0}, 1, kGlass}})), 0u) << "they touch in a point";
  EXPECT_EQ(solidsOf(ballsScene({{{0, 0, 0}, 1, kGlass}, {{0, 0, 0}, 0.5, kMatte}})), 0u) << "opaque";
  EXPECT_EQ(solidsOf(ballsScene({{{0, 0, 0}, 1, kGlass}, {{0, 0, 0}, -0.5, kGlass}})), 0u) << "a hollow ball is one";
  EXPECT_EQ(solidsOf(emptyScene()), 0u);
}

TEST(NestedDielectrics, OfTwoTheSmallerIsSeen) {
  for (const bool waterFirst : {false, true}) {
    vector<Sphere> balls = {{{0, 0, 0}, 1, kGlass}, {{0.5, 0, 0}, 0.75, kWater}};
    if (waterFirst) std::swap(balls[0], balls[1]);
    const NestedDielectrics dielectrics = findNestedDielectrics(ballsScene(balls));
    EXPECT_EQ(dielectrics.materials, (vector<uint32_t>{kGlass, kWater}));
    EXPECT_EQ(dielectrics.ofSpheres, waterFirst ? (vector<uint32_t>{1, 0}) : (vector<uint32_t>{0, 1}));
  }
}

TEST(NestedDielectrics, OfEqualOnesTheLater) {
  const NestedDielectrics dielectrics =
      findNestedDielectrics(ballsScene({{{0, 0, 0}, 1, kWater}, {{0.5, 0, 0}, 1, kGlass}}));
  EXPECT_EQ(dielectrics.materials, (vector<uint32_t>{kWater, kGlass}));
  EXPECT_EQ(dielectrics.ofSpheres, (vector<uint32_t>{0, 1}));
}

TEST(NestedDielectrics, MaterialsOfEqualValuesAreTheSameGlass) {
  const NestedDielectrics dielectrics =
      findNestedDielectrics(ballsScene({{{0, 0, 0}, 3, kGlass}, {{0, 0, 0}, 2, kWater}, {{0, 0, 0}, 1, kOtherGlass}}));
  ASSERT_EQ(dielectrics.materials, (vector<uint32_t>{kGlass, kWater, kOtherGlass}));
  EXPECT_EQ(dielectrics.glasses[0], dielectrics.glasses[2]);
  EXPECT_NE(dielectrics.glasses[0], dielectrics.glasses[1]);
}

TEST(NestedDielectrics, OnlyThoseThatMeetAnother) {
  const NestedDielectrics dielectrics = findNestedDielectrics(
      ballsScene({{{9, 0, 0}, 1, kGlass}, {{0, 0, 0}, 1, kGlass}, {{-9, 0, 0}, 1, kWater}, {{1, 0, 0}, 0.9, kWater}}));
  EXPECT_EQ(dielectrics.ofSpheres, (vector<uint32_t>{kNoMedium, 0, kNoMedium, 1}));
}

TEST(NestedDielectrics, HollowsBelongToTheSmallestAroundThem) {
  // A ball in a hollow of another, and both in a third one.
  const NestedDielectrics dielectrics = findNestedDielectrics(ballsScene({{{0, 0, 0}, 4, kGlass},
                                                                          {{0, 0, 0}, 3, kWater},
                                                                          {{0, 0, 0}, -2, kWater},
                                                                          {{0, 0, 0}, 1, kGlass},
                                                                          {{7, 0, 0}, -1, kWater}}));
  EXPECT_EQ(dielectrics.ofSpheres, (vector<uint32_t>{0, 1, 1, 2, kNoMedium}));
}

TEST(NestedDielectrics, ClosedTrianglesMakeOne) {
  Scene scene = emptyScene();
  addBox(scene, {0, 0, 0}, {1, 1, 1}, kGlass);
  addBox(scene, {1, 0, 0}, {2, 2, 2}, kWater);
  NestedDielectrics dielectrics = findNestedDielectrics(scene);
  EXPECT_EQ(dielectrics.materials, (vector<uint32_t>{kWater, kGlass})) << "they share a part of a face";
  EXPECT_EQ(std::count(dielectrics.ofTriangles.begin(), dielectrics.ofTriangles.end(), 1u), 12);

  Scene open = scene;
  open.triangles.erase(open.triangles.begin() + 3);
  EXPECT_EQ(solidsOf(open), 0u) << "a box with a hole in it";
  Scene turned = scene;
  std::swap(turned.triangles[3].positions[0], turned.triangles[3].positions[1]);
  EXPECT_EQ(solidsOf(turned), 0u) << "a triangle faces the wrong way";
  Scene apart = emptyScene();
  addBox(apart, {0, 0, 0}, {1, 1, 1}, kGlass);
  addBox(apart, {1.001, 0, 0}, {2, 1, 1}, kWater);
  EXPECT_EQ(solidsOf(apart), 0u);
}

// The same positions under fewer indices: each of the last `kept` triangles keeps its own.
Scene weld(const Scene& scene, size_t kept) {
  Scene welded = scene;
  for (size_t i = 0; i + kept < scene.triangles.size(); ++i)
    for (uint32_t& index : welded.triangles[i].positions)
      index = uint32_t(std::find(scene.positions.begin(), scene.positions.end(), scene.positions[index]) -
                       scene.positions.begin());
  return welded;
}

TEST(NestedDielectrics, SolidsDoNotDependOnWhetherVerticesAreRepeated) {
  Scene scene = emptyScene();
  addBox(scene, {0, 0, 0}, {1, 1, 1}, kGlass);
  addBox(scene, {1, 0, 0}, {2, 1, 1}, kGlass);
  addBox(scene, {0.5, 0.5, 0.5}, {3, 3, 3}, kWater);
  const NestedDielectrics expected = findNestedDielectrics(scene);
  ASSERT_EQ(expected.materials.size(), 3u);
  for (const size_t kept : {0u, 7u, 30u}) {
    SCOPED_TRACE(kept);
    const NestedDielectrics found = findNestedDielectrics(weld(scene, kept));
    EXPECT_EQ(found.materials, expected.materials);
    EXPECT_EQ(found.ofTriangles, expected.ofTriangles);
  }
  scene.triangles.erase(scene.triangles.begin() + 30);
  EXPECT_EQ(solidsOf(scene), 2u) << "a box with a hole in it";
  EXPECT_EQ(solidsOf(weld(scene, 0)), 2u);
}

TEST(NestedDielectrics, BoxesOfOneMaterialInARowAreTwo) {
  Scene scene = emptyScene();
  addBox(scene, {0, 0, 0}, {1, 1, 1}, kGlass);
  addBox(scene, {1, 0, 0}, {2, 1, 1}, kGlass);
  const NestedDielectrics dielectrics = findNestedDielectrics(scene);
  EXPECT_EQ(dielectrics.materials.size(), 2u);
  EXPECT_EQ(std::count(dielectrics.ofTriangles.begin(), dielectrics.ofTriangles.end(), 0u), 12);
}

TEST(NestedDielectrics, TrianglesMeetWhereTheyCrossNotWhereTheirBoundsDo) {
  // Two slabs along a diagonal, within each other's bounds: 0.2 apart, then crossing.
  for (const bool crossing : {false, true}) {
    Scene scene = emptyScene();
    const dvec3 along(1, 1, 0), up(0, 0, 1), across(-0.1, 0.1, 0);
    addParallelepiped(scene, {0, 0, 0}, along, across, up, kGlass);
    addParallelepiped(scene, crossing ? dvec3(-0.05, 0.05, 0) : dvec3(-0.25, 0.25, 0), along, across, up, kWater);
    EXPECT_EQ(solidsOf(scene), crossing ? 2u : 0u);
  }
}

TEST(NestedDielectrics, SpheresAndMeshesMeet) {
  // An octahedron.
  Scene scene = emptyScene();
  for (int i = 0; i < 8; ++i) {
    const dvec3 x(i & 1 ? -1 : 1, 0, 0), y(0, i & 2 ? -1 : 1, 0), z(0, 0, i & 4 ? -1 : 1);
    const bool turned = (i & 1) ^ (i >> 1 & 1) ^ (i >> 2 & 1);
    scene.addTriangle({x, turned ? z : y, turned ? y : z}, kGlass);
  }
  const auto with = [&](const Sphere& sphere) {
    Scene both = scene;
    both.spheres = {sphere};
    return solidsOf(both);
  };
  EXPECT_EQ(with({{0, 0, 0}, 0.5, kWater}), 2u) << "inside";
  EXPECT_EQ(with({{1.2, 0, 0}, 0.5, kWater}), 2u) << "across";
  EXPECT_EQ(with({{0, 0, 0}, 3, kWater}), 2u) << "around";
  EXPECT_EQ(with({{2, 0, 0}, 0.5, kWater}), 0u) << "beside";
  EXPECT_EQ(with({{0.9, 0.9, 0.9}, 0.4, kWater}), 0u) << "in a corner of its bounds";
}

TEST(NestedDielectrics, VertexNormalsDecideTheFront) {
  Scene scene = emptyScene();
  addBox(scene, {0, 0, 0}, {1, 1, 1}, kGlass, true);
  addBox(scene, {1, 0, 0}, {2, 2, 2}, kWater);
  EXPECT_EQ(solidsOf(scene), 0u) << "inside out";
  for (size_t i = 0; i < 12; ++i) {
    const auto [a, b, c] = scene.cornersOf(i);
    scene.triangles[i].normals.fill(uint32_t(scene.normals.size()));
    scene.normals.push_back(glm::cross(c - a, b - a));
  }
  EXPECT_EQ(solidsOf(scene), 2u);
}

TEST(NestedDielectrics, KnowTheEyes) {
  Scene scene = ballsScene({{{0, 0, 0}, 3, kGlass}, {{0, 0, 0}, 2, kWater}, {{0, 0, 0}, -1, kWater}});
  addBox(scene, {-2.5, -2.5, -2.5}, {2.5, 2.5, 2.5}, kOtherGlass);
  const auto around = [&](const dvec3& eye) {
    scene.camera.eye = eye;
    const vector<uint32_t> exact = findNestedDielectrics(scene).aroundEye;
    EXPECT_EQ(findNestedDielectrics(roundScene(scene)).aroundEye, exact);
    return exact;
  };
  // By volume: the box, the ball of glass, that of water.
  EXPECT_EQ(around({0, 0, 9}), vector<uint32_t>{});
  EXPECT_EQ(around({0, 0, 2.75}), vector<uint32_t>{1});
  EXPECT_EQ(around({0, 0, 2.25}), (vector<uint32_t>{0, 1}));
  EXPECT_EQ(around({0, 0, 1.5}), (vector<uint32_t>{0, 1, 2}));
  EXPECT_EQ(around({0, 0, 0.5}), (vector<uint32_t>{0, 1})) << "in the hollow";
  EXPECT_EQ(around({2.4, 2.4, 2.4}), vector<uint32_t>{0}) << "in a corner of the box";
}

TEST(NestedDielectrics, ThoseOnSomethingOpaqueAreNoticedWhereRoundingSeparatesThem) {
  for (const double lean : {0.0, 0.25}) {
    for (const double gap : {0.0, 1e-8, 0.01}) {
      Scene scene = emptyScene();
      const dvec3 x(1, lean, 0), y(0, 1, 0), z(0, 0, 1);
      addQuad(scene, -4.0 * x - 4.0 * z, 8.0 * z, 8.0 * x, kMatte);
      addParallelepiped(scene, gap * y, x, y, z, kGlass);
      EXPECT_EQ(solidsOf(scene), gap < 0.01 && (gap > 0 || lean > 0) ? 1u : 0u) << lean << ' ' << gap;
      for (const Triangle& triangle : scene.triangles)
        if (triangle.material == kMatte)
          scene.positions[triangle.positions[0]] += 0.01 * y, scene.positions[triangle.positions[1]] -= 0.01 * y;
      EXPECT_EQ(solidsOf(scene), 0u) << "across each other";
    }
  }
  const auto balls = [&](double radius) {
    return solidsOf(ballsScene({{{1, 2, 3}, 1, kGlass}, {{1, 2, 3}, radius, kMatte}}));
  };
  EXPECT_EQ(balls(1), 0u) << "the same numbers are met at the same distance";
  EXPECT_EQ(balls(1 + 1e-8), 1u);
  EXPECT_EQ(balls(1 - 1e-6), 0u);
}

TEST(NestedDielectrics, SizesAndDistancesOfAllKindsInOneMaterial) {
  // A box of 2 mm with water in it, 5 mm from the eye, and a window of the same glass 2 km away.
  Scene scene = emptyScene();
  scene.camera = {.eye = {0, 0, 0.005}, .target = {0, 0, 0}};
  addBox(scene, dvec3(-0.001), dvec3(0.001), kGlass);
  addBox(scene, dvec3(-0.0005), dvec3(0.0005), kWater);
  EXPECT_EQ(solidsOf(scene), 2u);
  addBox(scene, {-1000, -1000, -2000}, {1000, 1000, -1999}, kGlass);
  EXPECT_EQ(solidsOf(scene), 2u);
}

// Half a million spheres and boxes, many of them in one another.
Scene manySolids() {
  Scene scene = emptyScene();
  for (int i = 0; i < 100000; ++i) scene.spheres.push_back({{0, 0, 0}, 1 + i * 1e-5, kGlass});  // one in the other
  for (int i = 0; i < 300000; ++i)
    scene.spheres.push_back({{3 * (i % 100), 3 * (i / 100 % 100), -10 - 3 * (i / 10000)}, 1, kWater});
  for (int i = 0; i < 20000; ++i) addBox(scene, dvec3(-1 - i * 1e-4), dvec3(1 + i * 1e-4), kWater);
  for (int i = 0; i < 30000; ++i)
    for (const double sign : {1.0, -0.5}) scene.spheres.push_back({{50, 0, 0}, sign * (1 + i * 1e-4), kOtherGlass});
  return scene;
}

TEST(NestedDielectrics, MillionsAreNoTrouble) {
  EXPECT_EQ(solidsOf(manySolids()), 150000u);
}

TEST(TimingNestedDielectrics, MillionsTakeSeconds) {
  const Scene scene = manySolids();
  const Stopwatch watch;
  EXPECT_EQ(solidsOf(scene), 150000u);
  const double seconds = watch.seconds();
  EXPECT_LT(seconds, 60) << "3 s by the logarithm, minutes by the square";
}

// How many values of two pictures differ by more than this.
size_t differences(const Image& a, const Image& b, float most) {
  size_t count = 0;
  for (size_t i = 0; i < a.rgb.size(); ++i) count += !(std::abs(a.rgb[i] - b.rgb[i]) <= most);
  return count;
}

// Blocks and films that are thinner than float32 can tell, tilted: the tree and the file's order decide nothing, and
// shader and reference agree.
TEST(NestedDielectrics, FilmsBetweenBlocksInAnyOrder) {
  const dvec3 x = glm::normalize(dvec3(1, 0.3, -0.4)), y = glm::normalize(glm::cross(dvec3(0.2, 0, 1), x)),
              z = glm::cross(x, y);
  for (const double film : {2e-6, 1e-5}) {
    Image first;
    for (const bool reversed : {false, true}) {
      Scene scene = emptyScene();
      scene.background = {0.5, 0.75, 1};
      scene.camera = {.eye = 4.0 * z + 1.5 * y, .target = {0, 0, 0}, .fov = 40};
      const double tops[] = {-1, 0, film, 2 * film, 1};
      const double indices[] = {1.5, 1.25, 2, 1.75};
      for (int k = 0; k < 4; ++k) scene.materials.push_back(glass(0.02 * k, 0.9, indices[k]));
      for (int i = 0; i < 4; ++i) {
        const int k = reversed ? 3 - i : i;
        addParallelepiped(scene, -x - z + tops[k] * y, 2.0 * x, (tops[k + 1] - tops[k]) * y, 2.0 * z, uint32_t(4 + k));
      }
      const RenderSettings settings = test::settingsOf(scene, 64, 64);
      const Image picture = test::renderShader(scene, settings);
      const Image witness = renderReference(roundScene(scene), settings).image;
      EXPECT_LE(differences(picture, witness, 1e-3f), 3u * 4) << film << " reversed " << reversed;
      if (reversed) {
        EXPECT_LE(differences(picture, first, 1e-3f), 3u * 4) << film;
      }
      first = picture;
    }
  }
}

// Vertex normals that turn over within a triangle do not change what is inside.
TEST(NestedDielectrics, SidesAreThoseOfWholeTriangles) {
  Scene scene = emptyScene();
  scene.background = {0.5, 0.75, 1};
  scene.camera = {.eye = {2, 3, 6}, .target = {0, 0, 0}, .fov = 40};
  addBox(scene, dvec3(-1), dvec3(1), kGlass);
  for (Triangle& triangle : scene.triangles) {
    const auto [a, b, c] = scene.cornersOf(triangle);
    const dvec3 n = glm::cross(b - a, c - a);
    const uint32_t first = uint32_t(scene.normals.size());
    triangle.normals = {first, first, first + 1};
    scene.normals.insert(scene.normals.end(), {n, -n});
  }
  scene.spheres = {{{0, 0, 0}, 0.5, kWater}};
  const RenderSettings settings = test::settingsOf(scene, 64, 64);
  EXPECT_LE(differences(test::renderShader(scene, settings), renderReference(roundScene(scene), settings).image, 1e-3f),
            3u * 4);
}

// Pictures in which a ray is in more solids than the kernel has room for are not made.
TEST(NestedDielectrics, TooManyAtOnceAreAnError) {
  Scene scene = emptyScene();
  scene.depth = 32;
  for (uint32_t i = 0; i < 10; ++i) {
    scene.materials.push_back(glass(0, 1, 1.5 + 0.01 * i));
    scene.spheres.push_back({{0, 0, 0}, 1.0 - 0.05 * i, uint32_t(scene.materials.size() - 1)});
  }
  const RenderSettings settings = test::settingsOf(scene, 32, 32);
  EXPECT_THROW(test::renderShader(scene, settings), RunError);
  scene.camera.eye = {0, 0, 0};
  scene.camera.target = {0, 0, -1};
  EXPECT_THROW(test::renderShader(scene, settings), InputError);
  scene.spheres.resize(8);
  EXPECT_NO_THROW(test::renderShader(scene, settings));
}

}  // namespace
}  // namespace turner
