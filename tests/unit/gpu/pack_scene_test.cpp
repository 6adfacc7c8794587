#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <random>
#include <string>
#include <type_traits>

#include "base/errors.h"
#include "gpu/pack_scene.h"
#include "support/closed_form.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

bool isFloat(double x) {
  return double(float(x)) == x;
}

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
    scene.addTriangle({corner, corner + glm::dvec3(size(random), 0, 0), corner + glm::dvec3(0, size(random), 0.1)},
                      uint32_t(i % 2));
    if (i % 3 != 0) continue;
    // A neighbour across the edge from the second vertex to the third; every other pair is smooth.
    const auto [a, b, c] = scene.cornersOf(scene.triangles.back());
    scene.addTriangle({c, b, b + c - a}, uint32_t(i % 2));
    if (i % 2 == 0) continue;
    scene.normals = {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
    for (size_t k = scene.triangles.size() - 2; k < scene.triangles.size(); ++k) scene.triangles[k].normals = {0, 1, 2};
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
  for (const Sphere& sphere : local.spheres) {
    EXPECT_TRUE(isFloat(sphere.radius));
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(isFloat(sphere.center[k]));
  }
  for (const glm::dvec3& position : local.positions)
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(isFloat(position[k]));
}

// Whatever visitValues leaves out stays a double, and the kernel computes with another one.
TEST(RoundScene, RoundsEveryValueOfLightsAndMaterials) {
  Scene scene = mixedScene();
  const double third = 1.0 / 3;
  Light light{.color = glm::dvec3(third)};
  Material material;
  size_t values = 0;
  const auto set = [&](auto& value) {
    value = std::decay_t<decltype(value)>(third);
    values += sizeof value / sizeof(double);
  };
  Light::visitValues(light, set);
  EXPECT_EQ((values + 3) * sizeof(double), offsetof(Light, falloff))
      << "all but the position, before what is no number";
  values = 0;
  Material::visitValues(material, set);
  EXPECT_EQ(values * sizeof(double), sizeof(Material) - sizeof(std::string)) << "all but the name";
  scene.lights = {light};
  scene.materials.push_back(material);

  const Scene local = roundScene(scene);
  const auto check = [&](const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
      EXPECT_TRUE(isFloat(value));
    else
      for (int k = 0; k < 3; ++k) EXPECT_TRUE(isFloat(value[k]));
  };
  Light::visitValues(local.lights[0], check);
  for (const Material& rounded : local.materials) Material::visitValues(rounded, check);
}

TEST(RoundScene, KeepsTheEyesHeightOverAGiantSphere) {
  const double height = 0x1p-13, radius = 1e6;  // the sum is a double
  for (const double sign : {1.0, -1.0}) {
    Scene scene;
    scene.camera = {.eye = {7, height, -3}, .target = {7, height, -11}};
    scene.materials = {closed_form::matte({1, 1, 1})};
    scene.spheres = {{{7, -radius, -3}, sign * radius}, {{7, -radius, -3}, 0.5 * radius}};
    const Scene local = roundScene(scene);
    const long double scale = localFrame(scene.camera).scale;
    const long double power = height * (2 * radius + height) * scale * scale;
    EXPECT_NEAR(double(eyePower(local.spheres[0]) / power), 1, 1e-8) << "float32 would round the height to 0";
    EXPECT_EQ(std::signbit(local.spheres[0].radius), sign < 0);
    EXPECT_TRUE(isNearEye(local.spheres[0]));
    EXPECT_FALSE(isNearEye(local.spheres[1]));
    const PackedScene packed = test::packed(scene, test::settingsOf(scene, 8, 8));
    EXPECT_TRUE(packed.features.nearSpheres);
  }
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
  far.positions[far.triangles[7].positions[1]].y = -1e29;
  EXPECT_THROW(checkReach(roundScene(far)), InputError);
  far.triangles.erase(far.triangles.begin() + 7);
  EXPECT_NO_THROW(checkReach(roundScene(far))) << "a vertex that no triangle has is far away";
  far = scene;
  far.camera.target = far.camera.eye + glm::dvec3(0, 0, -1e-10);
  EXPECT_THROW(checkReach(roundScene(far)), InputError);
  far = scene;
  far.lights.push_back({.position = {1e18, 0, 0}});
  EXPECT_THROW(checkReach(roundScene(far)), InputError);
}

PackedScene pack(const Scene& scene) {
  return test::packed(scene, test::settingsOf(scene, 64, 64));
}

TEST(Pack, RefusesATreeDeeperThanTheStack) {
  const Scene scene = mixedScene();
  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  Bvh bvh = buildBvh(prepared.boxes, prepared.typeStarts());
  bvh.depth = int(gpu::kMaxTreeDepth) + 1;
  EXPECT_THROW(packScene(prepared, bvh, test::settingsOf(scene, 64, 64)), RunError);
}

std::vector<gpu::uint> idsByRank(const PreparedGeometry& prepared) {
  const std::vector<gpu::uint> places = tieBreakRanks(prepared);
  std::vector<gpu::uint> ids(places.size(), gpu::kRefNone);
  for (gpu::uint id = 0; id < places.size(); ++id) ids.at(places[id]) = id;
  return ids;
}

TEST(Pack, OpaqueComesBeforeGlassAndGlassByPriority) {
  Scene scene = mixedScene();
  scene.materials = {closed_form::matte({1, 1, 1}), closed_form::glass(0, 1, 1.5), closed_form::glass(0, 1, 1.25)};
  // Glass; opaque; a large ball of glass and a small one of water in it; opaque.
  scene.spheres = {{{9, 0, 0}, 1, 1}, {{0, 9, 0}, 1, 0}, {{0, 0, 0}, 2, 1}, {{0, 0, 0}, 1, 2}, {{0, -9, 0}, 1, 0}};
  scene.triangles.clear();
  scene.normals.clear();
  EXPECT_EQ(idsByRank(prepareGeometry(roundScene(scene))), (std::vector<gpu::uint>{1, 4, 0, 3, 2}));
  EXPECT_TRUE(pack(scene).features.dielectrics);
  scene.spheres.pop_back();
  scene.spheres.erase(scene.spheres.begin() + 3);
  EXPECT_EQ(idsByRank(prepareGeometry(roundScene(scene))), (std::vector<gpu::uint>{1, 0, 2}));
  EXPECT_FALSE(pack(scene).features.dielectrics);
}

// Walks the packed tree as the kernel does.
struct PackedCensus {
  const PackedScene& packed;
  const Scene& local;
  std::vector<gpu::uint> ids;  // by precedence
  std::vector<int> seen;
  size_t pairs = 0;

  template <class Structure>
  Structure read(size_t word) const {
    Structure structure;
    EXPECT_LE(word + sizeof structure / sizeof(gpu::Word4), packed.primitives.size());
    std::memcpy(&structure, &packed.primitives.at(word), sizeof structure);
    return structure;
  }

  void visit(gpu::uint reference, const glm::dvec3& lo, const glm::dvec3& hi) {
    if (reference & gpu::kRefLeaf)
      visitLeaf(reference, lo, hi);
    else
      visitNode(packed.nodes.at(reference), reference);
  }

  void visitNode(const gpu::Node& node, gpu::uint index) {
    const gpu::uint tags = node.exponents >> 24, reference = node.reference, below = index + 1;
    glm::dvec3 lo[2], hi[2];
    for (int k = 0; k < 3; ++k) {
      const double origin = k == 0 ? node.origin.x : k == 1 ? node.origin.y : node.origin.z;
      const uint32_t planes = k == 0 ? node.planes.x : k == 1 ? node.planes.y : node.planes.z;
      const double scale = std::ldexp(1.0, int(node.exponents >> (8 * k) & 255) - 127);
      const auto plane = [&](int byte) { return origin + scale * (planes >> (8 * byte) & 255); };
      lo[0][k] = plane(0), hi[0][k] = plane(1), lo[1][k] = plane(2), hi[1][k] = plane(3);
    }
    const gpu::uint firstUnits = ((reference >> gpu::kRefCountShift & gpu::kRefCountMask) + 1) *
                                 (reference & gpu::kRefTriangle ? gpu::kPairUnits : gpu::kSphereUnits);
    const gpu::uint secondLeaf =
        gpu::kRefLeaf | (tags << 26 & 0x70000000u) | ((reference & gpu::kRefOffsetMask) + firstUnits);
    visit(tags & 1 ? reference : below, lo[0], hi[0]);
    visit(!(tags & 1) ? reference : !(tags & 2) ? below : secondLeaf, lo[1], hi[1]);
  }

  // The triangle is the scene's, its corners in cyclic order, each with its normal.
  template <class ExpectInside>
  void expectTriangle(gpu::uint rank, const std::array<gpu::vec3, 3>& vertices, const gpu::Plane& plane,
                      gpu::uint material, gpu::uint normals, const ExpectInside& expectInside) {
    const gpu::uint id = ids.at(rank);
    ++seen.at(id);
    const Triangle& triangle = local.triangles.at(id - local.spheres.size() - local.cones.size());
    EXPECT_EQ(material, triangle.material);
    EXPECT_EQ(normals != gpu::kRefNone, triangle.isSmooth());
    const TriangleCorners corners = local.cornersOf(triangle);
    const auto vector = [](const gpu::vec3& v) { return glm::dvec3(v.x, v.y, v.z); };
    size_t turn = 0;
    while (turn < 3 && vector(vertices[0]) != corners[turn]) ++turn;
    ASSERT_LT(turn, 3u);
    for (size_t i = 0; i < 3; ++i) {
      const glm::dvec3 vertex = vector(vertices[i]);
      EXPECT_EQ(vertex, corners[(turn + i) % 3]);
      expectInside(vertex);
      EXPECT_NEAR(glm::dot(vector(plane.normal), vertex), double(plane.offset), 1e-6);
      if (normals == gpu::kRefNone) continue;
      const gpu::VertexNormals& n = packed.vertexNormals.at(normals);
      EXPECT_EQ(vector(i == 0 ? n.n0 : i == 1 ? n.n1 : n.n2), local.normalsOf(triangle)[(turn + i) % 3]);
    }
    const auto& [a, b, c] = corners;
    EXPECT_GT(glm::dot(vector(plane.normal), glm::cross(b - a, c - a)), 0);
  }

  void visitLeaf(gpu::uint reference, const glm::dvec3& lo, const glm::dvec3& hi) {
    const auto expectInside = [&](const glm::dvec3& p) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_GE(p[k], lo[k]);
        EXPECT_LE(p[k], hi[k]);
      }
    };
    size_t word = gpu::kUnitWords * size_t(reference & gpu::kRefOffsetMask);
    for (gpu::uint left = (reference >> gpu::kRefCountShift & gpu::kRefCountMask) + 1; left > 0; --left) {
      if (reference & gpu::kRefTriangle) {
        const auto pair = read<gpu::TrianglePair>(word);
        ++pairs;
        expectTriangle(pair.rank0, {pair.v0, pair.v1, pair.v2}, pair.planes[0], pair.material, pair.normals,
                       expectInside);
        if (pair.rank1 != gpu::kRefNone) {
          const gpu::uint normals = pair.normals == gpu::kRefNone ? gpu::kRefNone : pair.normals + 1;
          expectTriangle(pair.rank1, {pair.v3, pair.v2, pair.v1}, pair.planes[1], pair.material, normals, expectInside);
        }
        word += gpu::kPairUnits * gpu::kUnitWords;
      } else {
        const auto packedSphere = read<gpu::Sphere>(word);
        const uint32_t id = ids.at(packedSphere.rank);
        ++seen.at(id);
        const Sphere& sphere = local.spheres.at(id);
        expectInside(sphere.center - sphere.radius);
        expectInside(sphere.center + sphere.radius);
        EXPECT_EQ(packedSphere.radius, float(sphere.radius));
        word += gpu::kSphereUnits * gpu::kUnitWords;
      }
    }
  }
};

TEST(Pack, EveryPrimitiveIsReachedOnceAndInItsBoxes) {
  const Scene scene = mixedScene();
  const Scene local = roundScene(scene);
  const PackedScene packed = pack(scene);
  PackedCensus census{packed, local, idsByRank(prepareGeometry(local)), std::vector<int>(700, 0)};
  census.visit(packed.view.root, glm::dvec3(-INFINITY), glm::dvec3(INFINITY));
  EXPECT_EQ(census.pairs, 300u);  // 100 of two triangles, 200 of one
  for (const int times : census.seen) EXPECT_EQ(times, 1);
}

TEST(Pack, AsksForNoMoreThanTheSceneNeeds) {
  Scene scene = mixedScene();
  Features features = pack(scene).features;
  EXPECT_TRUE(features.spheres && features.triangles && features.reflection && features.refraction);
  EXPECT_TRUE(features.smoothNormals);
  EXPECT_FALSE(features.highlights || features.falloff);
  scene.spheres.clear();
  for (Triangle& triangle : scene.triangles) triangle = {.positions = triangle.positions};
  features = pack(scene).features;
  EXPECT_FALSE(features.spheres || features.smoothNormals || features.reflection || features.refraction)
      << "an unused material counts";
}

TEST(Pack, SumsOfTwoFloatsKeepTheCamera) {
  const Scene scene = mixedScene();
  const PackedScene packed = pack(scene);
  const gpu::Frame frame = packFrame(packed.view, test::settingsOf(scene, 640, 480), 1);
  const double tangent = std::tan(20 * closed_form::kDegree);
  EXPECT_NEAR(double(frame.rightHi.x) + double(frame.rightLo.x), 2 * tangent / 480, 1e-17);
  EXPECT_NEAR(double(frame.downHi.y) + double(frame.downLo.y), -2 * tangent / 480, 1e-17);
  EXPECT_EQ(double(frame.centreHi.z) + double(frame.centreLo.z), -1);
}

}  // namespace
}  // namespace turner
