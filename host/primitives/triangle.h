// Triangles, alone and in pairs: their bounds, and the packed form of a pair. The kernel's part is
// shaders/triangle.glsl.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "base/bounds.h"
#include "primitives/local_frame.h"

namespace turner {

namespace gpu {
struct TrianglePair;
}  // namespace gpu

inline constexpr uint32_t kNoNormals = UINT32_MAX;

struct Triangle {
  std::array<glm::dvec3, 3> vertices;  // counter-clockwise seen from the front
  uint32_t material = 0;
  uint32_t normals = kNoNormals;  // index into Scene::normals
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

Bounds boundsOf(const Triangle& triangle);

// Rounded to what the kernel computes with.
Triangle toLocal(const Triangle& world, const LocalFrame& frame);

// Whether float32 can hold it; of a local triangle.
bool isWithinReach(const Triangle& local);

// `second`: nullptr where the first is alone. `normals`: where the vertex normals of the first stand in the packed
// scene.
gpu::TrianglePair packPair(const Triangle& first, uint32_t firstRank, const Triangle* second, uint32_t secondRank,
                           uint32_t normals);

}  // namespace turner
