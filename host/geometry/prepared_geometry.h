// What the tree and the lists are built over: shapes, which are spheres, and triangles in pairs that share an edge;
// with a box around each.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/bounds.h"
#include "geometry/nested_dielectrics.h"
#include "scene/scene.h"

namespace turner {

// The kernel tests both triangles of a pair at once, with four vertices and five edges instead of six and six. They
// have the same material, and both or none have vertex normals.
struct TrianglePair {
  static constexpr uint32_t kNone = UINT32_MAX;
  uint32_t first;           // index in Scene::triangles
  uint32_t second = kNone;  // likewise; kNone: the first is alone
  bool isAlone() const { return second == kNone; }
};

struct PreparedGeometry {
  // From roundScene. The vertices of the triangles of a pair, and their normals, are turned so that the shared edge
  // lies between the second and the third vertex of both, in opposite directions. Behind the materials stands one for
  // each of `solids`, which its primitives have instead of the scene's.
  Scene scene;
  NestedDielectrics dielectrics;    // that overlap or touch
  uint32_t firstMedium = 0;         // material of the first
  std::vector<TrianglePair> pairs;  // every triangle is in one; in the order of their first ones
  // Of each sphere, then of each pair; padded outward, so that a ray which hits a primitive by the kernel's arithmetic
  // enters its box by the kernel's arithmetic.
  std::vector<Box> boxes;

  size_t firstPair() const { return scene.spheres.size(); }  // the first box that is a pair's
};

// `local` comes from roundScene. Pairs depend on the order of the triangles only. Works on all cores.
PreparedGeometry prepareGeometry(Scene local);

}  // namespace turner
