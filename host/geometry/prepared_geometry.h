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
  std::vector<size_t> typeStarts() const {
    std::vector<size_t> starts;
    size_t count = 0;
    Scene::visitPrimitives(scene, [&](const char*, const auto& list) { starts.push_back(count += list.size()); });
    starts.pop_back();
    return starts;
  }
  size_t firstPair() const { return scene.primitiveCount() - scene.triangles.size(); }
  size_t elementCount() const { return firstPair() + pairs.size(); }

  // Visits a primitive that is no triangle, or a pair.
  template <class Visit>
  decltype(auto) visitElement(size_t element, Visit&& visit) const {
    return visitOf<0>(element, visit);
  }

 private:
  template <size_t kType, class Visit>
  decltype(auto) visitOf(size_t element, Visit& visit) const {
    if constexpr (kType + 1 == Scene::kTypeNames.size()) {
      return visit(pairs[element]);
    } else {
      const auto& list = std::get<kType>(Scene::primitiveLists(scene));
      if (element >= list.size()) return visitOf<kType + 1>(element - list.size(), visit);
      return visit(list[element]);
    }
  }
};

// `local` comes from roundScene. Pairs depend on the order of the triangles only. Works on all cores.
PreparedGeometry prepareGeometry(Scene local);

}  // namespace turner
