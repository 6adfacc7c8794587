// Triangles, alone and in pairs: their bounds, and the packed form of a pair. The kernel's part is
// shaders/triangle.glsl.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "base/bounds.h"
#include "primitives/local_frame.h"

namespace turner {

struct Features;

namespace gpu {
struct TrianglePair;
}  // namespace gpu

inline constexpr uint32_t kNoNormals = UINT32_MAX;

// Three vertices' positions, or their normals.
using TriangleCorners = std::array<glm::dvec3, 3>;

// Vertices are shared: what moves one moves it in all its triangles. Scene::cornersOf and normalsOf look them up.
struct Triangle {
  std::array<uint32_t, 3> positions{};  // indices into Scene::positions, counter-clockwise seen from the front
  std::array<uint32_t, 3> normals{kNoNormals, kNoNormals, kNoNormals};  // into Scene::normals; all or none
  uint32_t material = 0;
  bool isSmooth() const { return normals[0] != kNoNormals; }
};

// The kernel tests both triangles of a pair at once, with four vertices and five edges instead of six and six. They
// have the same material, and both or none have vertex normals. The shared edge lies between the second and the third
// vertex of both, in opposite directions.
struct TrianglePair {
  static constexpr uint32_t kNone = UINT32_MAX;
  uint32_t first;           // index in Scene::triangles
  uint32_t second = kNone;  // likewise; kNone: the first is alone
  bool isAlone() const { return second == kNone; }
};

Bounds boundsOf(const TriangleCorners& corners);

// The same: roundScene rounds each position once, for all triangles that share it.
inline Triangle toLocal(const Triangle& world, const LocalFrame&) {
  return world;
}

// Whether float32 can hold it; of a local triangle.
bool isWithinReach(const TriangleCorners& local);

// Notes what such a primitive needs of the kernel.
void addFeatures(const Triangle& local, Features& features);

// `second`: nullptr where the first is alone. `normals`: where the vertex normals of the first stand in the packed
// scene, or kRefNone.
gpu::TrianglePair packPair(const TriangleCorners& first, uint32_t firstRank, const TriangleCorners* second,
                           uint32_t secondRank, uint32_t material, uint32_t normals);

}  // namespace turner
