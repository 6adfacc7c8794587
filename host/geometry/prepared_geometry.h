// What the tree and the lists are built over: elements, which are spheres, cones, and triangles in pairs that share an
// edge; with a box around each.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "base/bounds.h"
#include "geometry/nested_dielectrics.h"
#include "scene/scene.h"

namespace turner {

struct PreparedGeometry {
  // From roundScene. The corners of the triangles of a pair are turned so that the shared edge lies between the second
  // and the third vertex of both, in opposite directions. Behind the materials stands one for
  // each of `solids`, which its primitives have instead of the scene's.
  Scene scene;
  NestedDielectrics dielectrics;    // that overlap or touch
  uint32_t firstMedium = 0;         // material of the first
  std::vector<TrianglePair> pairs;  // every triangle is in one; in the order of their first ones
  // Of each element, in the order of their types: of each sphere, each cone, then each pair. Padded outward, so that a
  // ray which hits a primitive by the kernel's arithmetic enters its box by the kernel's arithmetic.
  std::vector<Box> boxes;

  // The first element of each type but the first.
  std::vector<size_t> typeStarts() const { return {scene.spheres.size(), firstPair()}; }
  size_t firstPair() const { return scene.spheres.size() + scene.cones.size(); }
  size_t elementCount() const { return firstPair() + pairs.size(); }

  // visit(const Sphere&), visit(const Cone&) or visit(const TrianglePair&).
  template <class Visit>
  decltype(auto) visitElement(size_t element, Visit&& visit) const {
    if (element < scene.spheres.size()) return visit(scene.spheres[element]);
    if (element < firstPair()) return visit(scene.cones[element - scene.spheres.size()]);
    return visit(pairs[element - firstPair()]);
  }
};

// `local` comes from roundScene. Pairs depend on the order of the triangles only. Works on all cores.
PreparedGeometry prepareGeometry(Scene local);

}  // namespace turner
