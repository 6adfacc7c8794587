// Numbers the primitives in the order of the leaves, and writes their rows.
#include "gpu/pack_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "base/errors.h"
#include "base/reserve.h"
#include "base/threads.h"
#include "gpu/pack_node.h"
#include "primitives/words.h"

namespace turner {
namespace {

using gpu::uint;
using gpu::Word4;

Features featuresOf(const Scene& scene) {
  Features features;
  features.lights = uint32_t(scene.lights.size());
  for (const Light& light : scene.lights) features.falloff |= light.falloff != Falloff::none;

  std::vector<bool> used(scene.materials.size());
  Scene::visitPrimitives(scene, [&](const char*, const auto& primitives) {
    for (const auto& primitive : primitives) {
      addFeatures(primitive, features);
      used[primitive.material] = true;
    }
  });
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

// Units of the element that holds such a primitive; triangles stand in pairs.
template <class Primitive>
constexpr uint kUnitsOf = sizeof(packed(Primitive(), 0)) / (gpu::kUnitWords * sizeof(Word4));
template <>
constexpr uint kUnitsOf<Triangle> = gpu::kPairUnits;

// What an element takes of the packed scene.
struct Footprint {
  uint type;  // bits of a reference
  uint units;
  uint vertexNormals = 0;
};
template <class Primitive>
Footprint footprintOf(const Scene&, const Primitive& primitive) {
  return {referenceType(primitive), kUnitsOf<Primitive>};
}
Footprint footprintOf(const Scene& scene, const TrianglePair& pair) {
  const bool isSmooth = scene.triangles[pair.first].isSmooth();
  return {gpu::kRefTriangle, gpu::kPairUnits, isSmooth ? (pair.isAlone() ? 1u : 2u) : 0u};
}

// As "8 spheres, 4 cones or 2 triangles": of which scenes there is room.
std::string mostOfEach() {
  std::vector<std::string> most;
  const Scene none;
  Scene::visitPrimitives(none, [&]<class Primitive>(const char* type, const std::vector<Primitive>&) {
    most.push_back(std::to_string(gpu::kMaxUnits / kUnitsOf<Primitive>) + ' ' + type);
  });
  std::string text = most.front();
  for (size_t i = 1; i < most.size(); ++i) text += (i + 1 < most.size() ? ", " : " or ") + most[i];
  return text;
}

// Throws where the kernel's numbers have no room for the scene.
void checkLimits(const PreparedGeometry& prepared, uint64_t units, int treeDepth) {
  if (units > gpu::kMaxUnits)
    throw InputError(
        "the scene has more primitives than the kernel can number: " + std::to_string(prepared.scene.primitiveCount()) +
        "; it takes " + mostOfEach() + ", twice as many triangles where all are in pairs");
  if (treeDepth > int(gpu::kMaxTreeDepth))
    throw RunError("the tree is " + std::to_string(treeDepth) + " nodes deep, more than the kernel's stack holds");

  if (!prepared.dielectrics.empty() && prepared.scene.materials.size() > gpu::kMaxMaterials)
    throw InputError("the scene has " + std::to_string(prepared.firstMedium) + " materials and " +
                     std::to_string(prepared.dielectrics.materials.size()) +
                     " solids of glass that overlap or touch; the kernel can number " +
                     std::to_string(gpu::kMaxMaterials) + " of both; use --backend reference");
}

// Where the elements go, in the order of the leaves.
struct Placement {
  std::vector<uint> references;  // type and offset of each
  std::vector<uint> normals;     // offset of its vertex normals
  uint64_t units = 0;            // of all; more than kMaxUnits: the references are no use
  uint vertexNormals = 0;
};

Placement placeElements(const PreparedGeometry& prepared, const Bvh& bvh) {
  Placement placement;
  reservePrefaulted(placement.references, bvh.order.size());
  reservePrefaulted(placement.normals, bvh.order.size());
  for (const uint element : bvh.order) {
    const Footprint footprint =
        prepared.visitElement(element, [&](const auto& e) { return footprintOf(prepared.scene, e); });
    placement.references.push_back(footprint.type | uint(placement.units));
    placement.normals.push_back(placement.vertexNormals);
    placement.units += footprint.units;
    placement.vertexNormals += footprint.vertexNormals;
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

// Writes the elements, each at its place, and the vertex normals.
class ElementPacker {
 public:
  // `nearSpheres` have their NearSphere behind all materials.
  ElementPacker(const PreparedGeometry& prepared, const Bvh& bvh, const Placement& placement,
                std::span<const uint> nearSpheres, PackedScene& packed)
      : prepared_(prepared), bvh_(bvh), placement_(placement), nearSpheres_(nearSpheres), packed_(packed) {}

  void pack() {
    // The kernel may look for all of a pair behind a last sphere.
    const size_t words = gpu::kUnitWords * size_t(placement_.units + gpu::kPairUnits);
    reservePrefaulted(packed_.primitives, words);
    packed_.primitives.resize(words);
    reservePrefaulted(packed_.vertexNormals, placement_.vertexNormals);
    packed_.vertexNormals.resize(placement_.vertexNormals);
    forAll(bvh_.order.size(),
           [&](size_t i) { prepared_.visitElement(bvh_.order[i], [&](const auto& element) { pack(i, element); }); });
  }

 private:
  template <class Structure>
  void put(size_t i, const Structure& structure) {
    const uint unit = placement_.references[i] & gpu::kRefOffsetMask;
    std::memcpy(&packed_.primitives[gpu::kUnitWords * size_t(unit)], &structure, sizeof structure);
  }

  // The tie-break rank; without glass, the id.
  uint rankOf(uint id) const { return ranks_.empty() ? id : ranks_[id]; }

  // The i-th of the leaves' order.
  template <class Primitive>
  void pack(size_t i, const Primitive& primitive) {
    put(i, packed(primitive, rankOf(bvh_.order[i])));
  }

  void pack(size_t i, const Sphere& sphere) {
    const uint id = bvh_.order[i];
    const auto near = std::lower_bound(nearSpheres_.begin(), nearSpheres_.end(), id);
    if (near == nearSpheres_.end() || *near != id) return put(i, packed(sphere, rankOf(id)));
    const uint materials = gpu::kMaterialWords * uint(prepared_.scene.materials.size());
    put(i, packNearSphere(sphere, rankOf(id), materials + uint(near - nearSpheres_.begin())));
  }

  void pack(size_t i, const TrianglePair& pair) {
    const Scene& scene = prepared_.scene;
    const auto rank = [&](uint triangle) { return rankOf(uint(prepared_.firstPair()) + triangle); };
    const Triangle &first = scene.triangles[pair.first],
                   &second = scene.triangles[pair.isAlone() ? pair.first : pair.second];
    const TriangleCorners corners = scene.cornersOf(first), others = scene.cornersOf(second);
    const uint normals = first.isSmooth() ? placement_.normals[i] : gpu::kRefNone;
    put(i, pair.isAlone() ? packPair(corners, rank(pair.first), nullptr, 0, first.material, normals)
                          : packPair(corners, rank(pair.first), &others, rank(pair.second), first.material, normals));
    if (!first.isSmooth()) return;
    packNormals(normals, first);
    if (!pair.isAlone()) packNormals(normals + 1, second);
  }

  void packNormals(size_t to, const Triangle& triangle) {
    const auto [a, b, c] = prepared_.scene.normalsOf(triangle);
    packed_.vertexNormals[to] = {toVec3(a), 0, toVec3(b), 0, toVec3(c), 0};
  }

  const PreparedGeometry& prepared_;
  const Bvh& bvh_;
  const Placement& placement_;
  const std::span<const uint> nearSpheres_;
  const std::vector<uint> ranks_ = hasGlass(prepared_.scene) ? tieBreakRanks(prepared_) : std::vector<uint>();
  PackedScene& packed_;
};

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
  const size_t count = scene.primitiveCount();
  std::vector<uint> result;
  reservePrefaulted(result, count);
  result.resize(count);
  if (!hasGlass(scene)) {
    std::iota(result.begin(), result.end(), 0u);
    return result;
  }
  // 0: opaque; 1: glass; 2 and more: a solid, less where its priority is higher.
  const auto groupOf = [&](uint material) {
    if (material >= prepared.firstMedium) return uint(scene.materials.size()) + 1 - material;
    return scene.materials[material].transmit > 0 ? 1u : 0u;
  };
  std::vector<uint> groups(count), starts(scene.materials.size() - prepared.firstMedium + 3);
  size_t firstId = 0;
  Scene::visitPrimitives(scene, [&](const char*, const auto& primitives) {
    forAll(primitives.size(), [&](size_t i) { groups[firstId + i] = groupOf(primitives[i].material); });
    firstId += primitives.size();
  });
  for (const uint group : groups) ++starts[group + 1];
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  for (size_t id = 0; id < count; ++id) result[id] = starts[groups[id]]++;
  return result;
}

size_t PackedScene::bytes() const {
  return nodes.size() * sizeof(gpu::Node) + (primitives.size() + lightBuffers.size()) * sizeof(gpu::Word4) +
         vertexNormals.size() * sizeof(gpu::VertexNormals);
}

size_t PackedScene::largestArray() const {
  return std::max({nodes.size() * sizeof(gpu::Node), primitives.size() * sizeof(gpu::Word4),
                   vertexNormals.size() * sizeof(gpu::VertexNormals), materials.size() * sizeof(gpu::Word4),
                   lights.size() * sizeof(gpu::Light), lightBuffers.size() * sizeof(gpu::Word4)});
}

PackedScene packScene(const PreparedGeometry& prepared, const Bvh& bvh, const RenderSettings& settings,
                      TraversalStart start) {
  const Placement placement = placeElements(prepared, bvh);
  checkLimits(prepared, placement.units, bvh.depth);
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
  packed.primitiveCount = local.primitiveCount();

  const std::vector<uint> nearSpheres = findNearSpheres(local);
  ElementPacker(prepared, bvh, placement, nearSpheres, packed).pack();
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
