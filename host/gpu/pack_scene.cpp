// Numbers both kinds of primitives in the order of the leaves, and writes their rows.
#include "gpu/pack_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "base/errors.h"
#include "base/reserve.h"
#include "base/threads.h"
#include "image/camera_basis.h"

namespace turner {
namespace {

using gpu::uint;
using gpu::Word4;

gpu::vec3 toVec3(const glm::dvec3& v) {
  return {float(v.x), float(v.y), float(v.z)};
}

// What a float leaves of a double: the low half of an unevaluated sum.
gpu::vec3 toVec3Rest(const glm::dvec3& v) {
  return toVec3(v - glm::dvec3(float(v.x), float(v.y), float(v.z)));
}

// Appends a structure of layout.h as the words that the kernel reads.
template <class Structure>
void append(std::vector<Word4>& words, const Structure& structure) {
  const size_t at = words.size();
  words.resize(at + sizeof(Structure) / sizeof(Word4));
  std::memcpy(&words[at], &structure, sizeof structure);
}

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

// `normals`: where its vertex normals stand in the packed scene. `precedence`: of the triangles.
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

// Trees are built within the builder's default limits; the kernel's numbers have room for no more.
static_assert(BvhLimits{}.maxLeafSize == gpu::kMaxLeafSize && BvhLimits{}.maxDepth == int(gpu::kMaxTreeDepth));

uint leafReference(const BvhChild& leaf, std::span<const uint> references) {
  return gpu::kRefLeaf | ((leaf.count - 1) << gpu::kRefCountShift) | references[leaf.first];
}

// The least power of two of which 255 reach over a distance, as the exponent byte of a float.
uint planeExponent(double distance) {
  const int exponent = distance > 0 ? std::ilogb(distance / 255) + 1 : -126;
  return uint(std::clamp(exponent, -126, 127) + 127);
}

// A node in the kernel's form: its planes in bytes, rounded outward; all of it exact in double.
gpu::Node packNode(const Bvh::Node& node, std::span<const uint> references) {
  // A leaf comes first, so that the kernel finds an inner child next to its parent.
  const bool swapped = node.children[0].count == 0 && node.children[1].count > 0;
  const BvhChild& first = node.children[swapped ? 1 : 0];
  const BvhChild& second = node.children[swapped ? 0 : 1];
  const glm::dvec3 lo = glm::min(first.box.lo, second.box.lo), hi = glm::max(first.box.hi, second.box.hi);

  uint exponents = 0;
  uint planes[3];
  for (int k = 0; k < 3; ++k) {
    const uint exponent = planeExponent(hi[k] - lo[k]);
    const double scale = std::ldexp(1.0, int(exponent) - 127);
    const auto down = [&](float plane) { return uint(std::floor((double(plane) - lo[k]) / scale)); };
    const auto up = [&](float plane) { return uint(std::ceil((double(plane) - lo[k]) / scale)); };
    planes[k] =
        down(first.box.lo[k]) | up(first.box.hi[k]) << 8 | down(second.box.lo[k]) << 16 | up(second.box.hi[k]) << 24;
    exponents |= exponent << (8 * k);
  }

  uint reference = second.first, tags = 0;
  if (first.count > 0) {
    reference = leafReference(first, references);
    tags = 1;
  }
  if (second.count > 0) {
    const uint leaf = references[second.first];
    tags = 3 | (second.count - 1) << 2 | (leaf & gpu::kRefTriangle ? 1u << 4 : 0u);
  }
  return {.origin = toVec3(lo),
          .exponents = exponents | tags << 24,
          .planes = {planes[0], planes[1], planes[2]},
          .reference = reference};
}

// The part of each face of the eye's cube that the picture's rays go through: its crop, clipped to the face.
std::array<FaceWindow, 6> viewWindows(const Camera& camera, const RenderSettings& settings) {
  const CameraBasis basis = cameraBasis(camera);
  const double pixel = 2 * basis.tanHalfFov / settings.height;
  const auto direction = [&](int x, int y) {
    return basis.forward + pixel * ((x - 0.5 * settings.width) * basis.right - (y - 0.5 * settings.height) * basis.up);
  };
  const Window& crop = settings.crop;
  std::array<FaceWindow, 6> windows;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double sign = face % 2 ? -1 : 1;
    std::vector<glm::dvec3> polygon = {direction(crop.x0, crop.y0), direction(crop.x1, crop.y0),
                                       direction(crop.x1, crop.y1), direction(crop.x0, crop.y1)};
    // Keep what lies within |u| <= 1 and |v| <= 1, plane by plane (Sutherland, Hodgman 1974), with room for rounding.
    for (const auto& [component, side] : {std::pair{a, 1.0}, {a, -1.0}, {b, 1.0}, {b, -1.0}}) {
      const auto inside = [&](const glm::dvec3& d) { return (1 + 1e-6) * sign * d[axis] - side * d[component]; };
      std::vector<glm::dvec3> kept;
      for (size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double ip = inside(p), iq = inside(q);
        if (ip >= 0) kept.push_back(p);
        if ((ip < 0) != (iq < 0)) kept.push_back(p + (ip / (ip - iq)) * (q - p));
      }
      polygon = std::move(kept);
    }
    FaceWindow& window = windows[size_t(face)];
    window = {1, -1, 1, -1};
    for (const glm::dvec3& d : polygon) {
      const double u = d[a] / d[axis], v = d[b] / d[axis];
      window = {std::min(window.uLo, u), std::max(window.uHi, u), std::min(window.vLo, v), std::max(window.vHi, v)};
    }
  }
  return windows;
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
  const Scene& local = prepared.scene;
  const size_t sphereCount = local.spheres.size();
  if (gpu::kSphereUnits * sphereCount + gpu::kPairUnits * prepared.pairs.size() > gpu::kMaxUnits)
    throw InputError("the scene has more spheres and triangles than the kernel can number: " +
                     std::to_string(sphereCount + local.triangles.size()) + "; it takes " +
                     std::to_string(gpu::kMaxUnits / gpu::kSphereUnits) + " spheres or " +
                     std::to_string(gpu::kMaxUnits / gpu::kPairUnits) +
                     " triangles, twice as many where all are in pairs");
  if (bvh.depth > int(gpu::kMaxTreeDepth))
    throw RunError("the tree is " + std::to_string(bvh.depth) + " nodes deep, more than the kernel's stack holds");

  if (!prepared.dielectrics.empty() && local.materials.size() > gpu::kMaxMaterials)
    throw InputError("the scene has " + std::to_string(prepared.firstMedium) + " materials and " +
                     std::to_string(prepared.dielectrics.materials.size()) +
                     " solids of glass that overlap or touch; the kernel can number " +
                     std::to_string(gpu::kMaxMaterials) + " of both; use --backend reference");

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
  packed.primitiveCount = sphereCount + local.triangles.size();

  // Kind and place of each shape, and the place of its vertex normals, in the order of the leaves.
  std::vector<uint> references, normals;
  reservePrefaulted(references, bvh.order.size());
  reservePrefaulted(normals, bvh.order.size());
  uint offset = 0, normalsOffset = 0;
  for (const uint primitive : bvh.order) {
    const bool isPair = primitive >= sphereCount;
    references.push_back((isPair ? gpu::kRefTriangle : 0) | offset);
    normals.push_back(normalsOffset);
    offset += isPair ? gpu::kPairUnits : gpu::kSphereUnits;
    if (!isPair) continue;
    const TrianglePair& pair = prepared.pairs[primitive - sphereCount];
    if (local.triangles[pair.first].normals != kNoNormals) normalsOffset += pair.isAlone() ? 1 : 2;
  }
  const std::vector<uint> rank = tieBreakRanks(prepared);
  std::vector<uint> nearSpheres;
  for (uint i = 0; i < sphereCount; ++i) {
    if (isNearEye(local.spheres[i])) nearSpheres.push_back(i);
    packed.features.farSpheres |= isFarFromEye(local.spheres[i]);
  }
  packed.features.nearSpheres = !nearSpheres.empty();
  const uint nearSpheresAt = gpu::kMaterialWords * uint(local.materials.size());
  // The kernel may look for all of a pair behind a last sphere.
  reservePrefaulted(packed.primitives, gpu::kUnitWords * (offset + gpu::kPairUnits));
  packed.primitives.resize(gpu::kUnitWords * (offset + gpu::kPairUnits));
  reservePrefaulted(packed.vertexNormals, normalsOffset);
  packed.vertexNormals.resize(normalsOffset);
  forAll(bvh.order.size(), [&](size_t i) {
    const uint primitive = bvh.order[i];
    Word4* const words = &packed.primitives[gpu::kUnitWords * (references[i] & gpu::kRefOffsetMask)];
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
    const gpu::TrianglePair packedPair = packPair(prepared, pair, normals[i], std::span(rank).subspan(sphereCount));
    std::memcpy(words, &packedPair, sizeof packedPair);
    if (local.triangles[pair.first].normals == kNoNormals) return;
    const auto putNormals = [&](size_t to, uint triangle) {
      const auto& [a, b, c] = local.normals[local.triangles[triangle].normals];
      packed.vertexNormals[to] = {toVec3(a), 0, toVec3(b), 0, toVec3(c), 0};
    };
    putNormals(normals[i], pair.first);
    if (!pair.isAlone()) putNormals(normals[i] + 1, pair.second);
  });

  reservePrefaulted(packed.nodes, bvh.nodes.size());
  packed.nodes.resize(bvh.nodes.size());
  forAll(bvh.nodes.size(), [&](size_t i) { packed.nodes[i] = packNode(bvh.nodes[i], references); });
  if (!bvh.order.empty()) packed.view.root = bvh.root.count > 0 ? leafReference(bvh.root, references) : bvh.root.first;

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
  for (const Light& light : local.lights)
    packed.lights.push_back({toVec3(light.position), light.falloff == Falloff::inverseSquare, toVec3(light.color), 0});

  // Eye rays share their walk with reflected and refracted ones, which begin at the root.
  const size_t eyeRays = settings.crop.area() * size_t(settings.samples) * size_t(settings.samples);
  const bool secondary = packed.features.reflection || packed.features.refraction;
  std::vector<LightBufferPoint> points = {{.position = {0, 0, 0},
                                           .windows = viewWindows(local.camera, settings),
                                           .rays = eyeRays,
                                           .kernelTraversal = 0,
                                           .traversalVisitsNodes = secondary || start == TraversalStart::mixedLists}};
  for (const Light& light : local.lights)
    points.push_back({.position = light.position,
                      .rays = eyeRays,
                      .kernelTraversal = 1,
                      .traversalVisitsNodes = start == TraversalStart::mixedLists});
  const LightBufferTree tree{prepared, bvh, references};
  LightBuffers built =
      start == TraversalStart::wholeTree ? wholeTreeLightBuffers(points, tree) : buildLightBuffers(points, tree);
  packed.lightBuffers = std::move(built.rows);
  packed.features.nearestNodes = built.visitsNodes[0];
  packed.features.shadowNodes = !local.lights.empty() && built.visitsNodes[1];
  return packed;
}

gpu::Frame packFrame(const View& view, const RenderSettings& settings, uint32_t deviceThreads) {
  const CameraBasis basis = cameraBasis(view.camera);
  const double pixel = 2 * basis.tanHalfFov / settings.height;
  const glm::dvec3 perRight = pixel * basis.right, perDown = -pixel * basis.up;

  gpu::Frame frame{};
  frame.centreHi = toVec3(basis.forward);
  frame.centreLo = toVec3Rest(basis.forward);
  frame.rightHi = toVec3(perRight);
  frame.rightLo = toVec3Rest(perRight);
  frame.downHi = toVec3(perDown);
  frame.downLo = toVec3Rest(perDown);
  frame.background = toVec3(view.background);
  frame.media = view.media;
  frame.root = view.root;
  frame.width = uint(settings.width);
  frame.height = uint(settings.height);
  frame.seed = settings.seed;
  frame.minWeight = float(settings.weightLimit());
  frame.threads = deviceThreads;
  frame.canaryLength = gpu::kCanaryLength;
  return frame;
}

}  // namespace turner
