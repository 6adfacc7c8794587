// Numbers the primitives in the order of the leaves, and writes their rows.
#include "gpu/pack_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <glm/geometric.hpp>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "base/errors.h"
#include "base/reserve.h"
#include "base/threads.h"
#include "gpu/pack_node.h"
#include "gpu/words.h"

namespace turner {
namespace {

using gpu::uint;
using gpu::Word4;

struct Plane {
  glm::dvec3 normal;  // unit, on the counter-clockwise side
  double offset;      // N.x of its points
};

// Nothing where the triangle has no area. The same for all orders of the same vertices but for the sign: coincident
// triangles are hit at equal distances then, and the lowest id wins.
std::optional<Plane> planeOf(std::array<glm::dvec3, 3> v) {
  const auto less = [](const glm::dvec3& a, const glm::dvec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  double sign = 1;
  for (const auto& [i, j] : {std::pair<size_t, size_t>{0, 1}, {1, 2}, {0, 1}}) {
    if (!less(v[j], v[i])) continue;
    std::swap(v[i], v[j]);
    sign = -sign;
  }
  const glm::dvec3 cross = glm::cross(v[1] - v[0], v[2] - v[0]);
  const double length = glm::length(cross);
  if (length == 0) return {};
  const glm::dvec3 normal = cross / length;
  return Plane{sign * normal, sign * glm::dot(normal, v[0])};
}

// A triangle that rounding has made flat has no plane: it is seen edge-on by every ray and never hit.
gpu::Plane packPlane(const Triangle& triangle) {
  const std::optional<Plane> plane = planeOf(triangle.vertices);
  return plane ? gpu::Plane{toVec3(plane->normal), float(plane->offset)} : gpu::Plane{};
}

gpu::Sphere packSphere(const Sphere& sphere, uint rank) {
  return {toVec3(sphere.center), float(sphere.radius), rank, sphere.material, 0, 0};
}

// The same of one that the eye is near; its NearSphere is at this word among the materials.
gpu::Sphere packNearSphere(const Sphere& sphere, uint rank, uint restAt) {
  gpu::Sphere near = packSphere(sphere, rank);
  near.material |= gpu::kNearEye;
  near.nearSphere = restAt;
  near.eyePower = float(eyePower(sphere));
  return near;
}

gpu::NearSphere nearSphereOf(const Sphere& sphere) {
  const long double power = eyePower(sphere);
  return {toVec3Rest(sphere.center), float(power - float(power))};
}

// `normals`: where its vertex normals stand in the packed scene. `rank`: of the triangles.
gpu::TrianglePair packPair(const PreparedGeometry& prepared, const TrianglePair& pair, uint normals,
                           std::span<const uint> rank) {
  const std::vector<Triangle>& triangles = prepared.scene.triangles;
  const Triangle& first = triangles[pair.first];
  const auto& [a, b, c] = first.vertices;
  gpu::TrianglePair packed{.v0 = toVec3(a),
                           .rank0 = rank[pair.first],
                           .v1 = toVec3(b),
                           .material = first.material,
                           .v2 = toVec3(c),
                           .normals = first.normals == kNoNormals ? gpu::kRefNone : normals,
                           .v3 = toVec3(b),
                           .rank1 = gpu::kRefNone,
                           .planes = {packPlane(first), {}}};
  if (!pair.isAlone()) {
    const Triangle& second = triangles[pair.second];
    packed.v3 = toVec3(second.vertices[0]);
    packed.rank1 = rank[pair.second];
    packed.planes[1] = packPlane(second);
  }
  return packed;
}

Features featuresOf(const Scene& scene) {
  Features features;
  features.lights = uint32_t(scene.lights.size());
  features.spheres = !scene.spheres.empty();
  features.triangles = !scene.triangles.empty();
  for (const Light& light : scene.lights) features.falloff |= light.falloff != Falloff::none;

  std::vector<bool> used(scene.materials.size());
  for (const Sphere& sphere : scene.spheres) used[sphere.material] = true;
  for (const Triangle& triangle : scene.triangles) {
    used[triangle.material] = true;
    features.smoothNormals |= triangle.normals != kNoNormals;
  }
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const Material& material = scene.materials[i];
    features.highlights |= material.localWeight > 0 && material.specular != glm::dvec3(0);
    features.reflection |= material.reflect > 0;
    features.refraction |= material.transmit > 0;
  }
  return features;
}

// Two of them in each word.
gpu::uvec4 mediaAroundEye(const PreparedGeometry& prepared) {
  const std::vector<uint32_t>& media = prepared.dielectrics.aroundEye;
  if (media.size() > gpu::kMaxMedia)
    throw InputError("the camera's eye is in " + std::to_string(media.size()) +
                     " solids of glass that overlap; a ray can be in " + std::to_string(gpu::kMaxMedia) +
                     "; use --backend reference");
  std::array<uint, 4> words{};
  for (size_t i = 0; i < media.size(); ++i) words[i % 4] |= (prepared.firstMedium + media[i]) << (i < 4 ? 0 : 16);
  return std::bit_cast<gpu::uvec4>(words);
}

// Throws where the kernel's numbers have no room for the scene.
void checkLimits(const PreparedGeometry& prepared, int treeDepth) {
  const Scene& local = prepared.scene;
  const size_t sphereCount = local.spheres.size();
  if (gpu::kSphereUnits * sphereCount + gpu::kPairUnits * prepared.pairs.size() > gpu::kMaxUnits)
    throw InputError("the scene has more spheres and triangles than the kernel can number: " +
                     std::to_string(sphereCount + local.triangles.size()) + "; it takes " +
                     std::to_string(gpu::kMaxUnits / gpu::kSphereUnits) + " spheres or " +
                     std::to_string(gpu::kMaxUnits / gpu::kPairUnits) +
                     " triangles, twice as many where all are in pairs");
  if (treeDepth > int(gpu::kMaxTreeDepth))
    throw RunError("the tree is " + std::to_string(treeDepth) + " nodes deep, more than the kernel's stack holds");

  if (!prepared.dielectrics.empty() && local.materials.size() > gpu::kMaxMaterials)
    throw InputError("the scene has " + std::to_string(prepared.firstMedium) + " materials and " +
                     std::to_string(prepared.dielectrics.materials.size()) +
                     " solids of glass that overlap or touch; the kernel can number " +
                     std::to_string(gpu::kMaxMaterials) + " of both; use --backend reference");
}

// Where the primitives go, in the order of the leaves.
struct Placement {
  std::vector<uint> references;       // type and offset of each
  std::vector<uint> normals;          // offset of its vertex normals
  uint units = 0, vertexNormals = 0;  // of all
};

Placement placePrimitives(const PreparedGeometry& prepared, const Bvh& bvh) {
  const std::vector<Triangle>& triangles = prepared.scene.triangles;
  Placement placement;
  reservePrefaulted(placement.references, bvh.order.size());
  reservePrefaulted(placement.normals, bvh.order.size());
  for (const uint primitive : bvh.order) {
    const bool isPair = primitive >= prepared.firstPair();
    placement.references.push_back((isPair ? gpu::kRefTriangle : 0) | placement.units);
    placement.normals.push_back(placement.vertexNormals);
    placement.units += isPair ? gpu::kPairUnits : gpu::kSphereUnits;
    if (!isPair) continue;
    const TrianglePair& pair = prepared.pairs[primitive - prepared.firstPair()];
    if (triangles[pair.first].normals != kNoNormals) placement.vertexNormals += pair.isAlone() ? 1 : 2;
  }
  return placement;
}

// Of the spheres that the eye is near, ascending.
std::vector<uint> findNearSpheres(const Scene& scene) {
  std::vector<uint> found;
  for (uint i = 0; i < scene.spheres.size(); ++i)
    if (isNearEye(scene.spheres[i])) found.push_back(i);
  return found;
}

// Primitives and vertex normals. `nearSpheres` have their NearSphere behind all materials.
void packGeometry(const PreparedGeometry& prepared, const Bvh& bvh, const Placement& placement,
                  std::span<const uint> nearSpheres, PackedScene& packed) {
  const Scene& local = prepared.scene;
  const size_t sphereCount = local.spheres.size();
  const std::vector<uint> rank = tieBreakRanks(prepared);
  const uint nearSpheresAt = gpu::kMaterialWords * uint(local.materials.size());
  // The kernel may look for all of a pair behind a last sphere.
  const size_t rowCount = gpu::kUnitWords * (placement.units + gpu::kPairUnits);
  reservePrefaulted(packed.primitives, rowCount);
  packed.primitives.resize(rowCount);
  reservePrefaulted(packed.vertexNormals, placement.vertexNormals);
  packed.vertexNormals.resize(placement.vertexNormals);
  forAll(bvh.order.size(), [&](size_t i) {
    const uint primitive = bvh.order[i];
    Word4* const words = &packed.primitives[gpu::kUnitWords * (placement.references[i] & gpu::kRefOffsetMask)];
    if (primitive < sphereCount) {
      const Sphere& sphere = local.spheres[primitive];
      const auto near = std::lower_bound(nearSpheres.begin(), nearSpheres.end(), primitive);
      const gpu::Sphere packedSphere =
          near == nearSpheres.end() || *near != primitive
              ? packSphere(sphere, rank[primitive])
              : packNearSphere(sphere, rank[primitive], nearSpheresAt + uint(near - nearSpheres.begin()));
      std::memcpy(words, &packedSphere, sizeof packedSphere);
      return;
    }
    const TrianglePair& pair = prepared.pairs[primitive - sphereCount];
    const gpu::TrianglePair packedPair =
        packPair(prepared, pair, placement.normals[i], std::span(rank).subspan(sphereCount));
    std::memcpy(words, &packedPair, sizeof packedPair);
    if (local.triangles[pair.first].normals == kNoNormals) return;
    const auto putNormals = [&](size_t to, uint triangle) {
      const auto& [a, b, c] = local.normals[local.triangles[triangle].normals];
      packed.vertexNormals[to] = {toVec3(a), 0, toVec3(b), 0, toVec3(c), 0};
    };
    putNormals(placement.normals[i], pair.first);
    if (!pair.isAlone()) putNormals(placement.normals[i] + 1, pair.second);
  });
}

// Nodes and root.
void packTree(const Bvh& bvh, std::span<const uint> references, PackedScene& packed) {
  reservePrefaulted(packed.nodes, bvh.nodes.size());
  packed.nodes.resize(bvh.nodes.size());
  forAll(bvh.nodes.size(), [&](size_t i) { packed.nodes[i] = packNode(bvh.nodes[i], references); });
  if (!bvh.order.empty()) packed.view.root = bvh.root.count > 0 ? leafReference(bvh.root, references) : bvh.root.first;
}

// Materials, then the NearSpheres.
void packMaterials(const PreparedGeometry& prepared, std::span<const uint> nearSpheres, PackedScene& packed) {
  const Scene& local = prepared.scene;
  for (uint i = 0; i < local.materials.size(); ++i) {
    const Material& material = local.materials[i];
    const uint glass = i < prepared.firstMedium ? 0 : 1 + prepared.dielectrics.glasses[i - prepared.firstMedium];
    append(packed.materials, gpu::Material{.diffuse = toVec3(material.diffuse),
                                           .reflectance = float(material.reflect),
                                           .specular = toVec3(material.specular),
                                           .transmittance = float(material.transmit),
                                           .shininess = float(material.shininess),
                                           .eta = float(material.eta),
                                           .localWeight = float(material.localWeight),
                                           .glass = glass});
  }
  for (const uint i : nearSpheres) append(packed.materials, nearSphereOf(local.spheres[i]));
}

void packLights(const Scene& scene, PackedScene& packed) {
  for (const Light& light : scene.lights)
    packed.lights.push_back({toVec3(light.position), light.falloff == Falloff::inverseSquare, toVec3(light.color), 0});
}

// The eye, then the lights.
std::vector<LightBufferPoint> planLightBuffers(const Scene& scene, const RenderSettings& settings,
                                               bool hasSecondaryRays, TraversalStart start) {
  // Eye rays share their traversal with reflected and refracted ones, which begin at the root.
  const size_t eyeRays = settings.crop.area() * size_t(settings.samples) * size_t(settings.samples);
  std::vector<LightBufferPoint> points = {
      {.position = {0, 0, 0},
       .windows = viewWindows(scene.camera, settings),
       .rays = eyeRays,
       .kernelTraversal = 0,
       .traversalVisitsNodes = hasSecondaryRays || start == TraversalStart::mixedLists}};
  for (const Light& light : scene.lights)
    points.push_back({.position = light.position,
                      .rays = eyeRays,
                      .kernelTraversal = 1,
                      .traversalVisitsNodes = start == TraversalStart::mixedLists});
  return points;
}

}  // namespace

std::vector<uint> tieBreakRanks(const PreparedGeometry& prepared) {
  const Scene& scene = prepared.scene;
  const size_t spheres = scene.spheres.size(), count = spheres + scene.triangles.size();
  std::vector<uint> result;
  reservePrefaulted(result, count);
  result.resize(count);
  // 0: opaque; 1: glass; 2 and more: a solid, less where its priority is higher.
  const auto groupOf = [&](size_t id) {
    const uint material = id < spheres ? scene.spheres[id].material : scene.triangles[id - spheres].material;
    if (material >= prepared.firstMedium) return uint(scene.materials.size()) + 1 - material;
    return scene.materials[material].transmit > 0 ? 1u : 0u;
  };
  if (!hasGlass(scene)) {
    std::iota(result.begin(), result.end(), 0u);
    return result;
  }
  std::vector<uint> groups(count), starts(scene.materials.size() - prepared.firstMedium + 3);
  forAll(count, [&](size_t id) { groups[id] = groupOf(id); });
  for (const uint group : groups) ++starts[group + 1];
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  for (size_t id = 0; id < count; ++id) result[id] = starts[groups[id]]++;
  return result;
}

size_t PackedScene::bytes() const {
  return nodes.size() * sizeof(gpu::Node) + (primitives.size() + lightBuffers.size()) * sizeof(gpu::Word4) +
         vertexNormals.size() * sizeof(gpu::VertexNormals);
}

PackedScene packScene(const PreparedGeometry& prepared, const Bvh& bvh, const RenderSettings& settings,
                      TraversalStart start) {
  checkLimits(prepared, bvh.depth);
  const Scene& local = prepared.scene;
  PackedScene packed;
  packed.features = featuresOf(local);
  packed.features.dielectrics = !prepared.dielectrics.empty();
  packed.view = {.camera = local.camera,
                 .background = local.background,
                 .media = mediaAroundEye(prepared),
                 .width = settings.width,
                 .height = settings.height,
                 .crop = settings.crop};
  packed.treeDepth = bvh.depth;
  packed.primitiveCount = local.spheres.size() + local.triangles.size();

  const std::vector<uint> nearSpheres = findNearSpheres(local);
  packed.features.nearSpheres = !nearSpheres.empty();
  for (const Sphere& sphere : local.spheres) packed.features.farSpheres |= isFarFromEye(sphere);

  const Placement placement = placePrimitives(prepared, bvh);
  packGeometry(prepared, bvh, placement, nearSpheres, packed);
  packTree(bvh, placement.references, packed);
  packMaterials(prepared, nearSpheres, packed);
  packLights(local, packed);

  const bool hasSecondaryRays = packed.features.reflection || packed.features.refraction;
  const std::vector<LightBufferPoint> points = planLightBuffers(local, settings, hasSecondaryRays, start);
  const LightBufferTree tree{prepared, bvh, placement.references};
  LightBuffers built =
      start == TraversalStart::wholeTree ? wholeTreeLightBuffers(points, tree) : buildLightBuffers(points, tree);
  packed.lightBuffers = std::move(built.rows);
  packed.features.nearestNodes = built.visitsNodes[0];
  packed.features.shadowNodes = !local.lights.empty() && built.visitsNodes[1];
  return packed;
}

}  // namespace turner
