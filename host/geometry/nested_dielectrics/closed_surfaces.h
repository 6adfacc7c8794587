// The closed surfaces of glass in a scene: spheres, and triangles that enclose a volume.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/nested_dielectrics.h"
#include "geometry/nested_dielectrics/bounds.h"
#include "scene/scene.h"

namespace turner::nested_dielectrics {

// A sphere, or triangles.
struct Surface {
  uint32_t material;
  uint32_t firstId;  // least id of its primitives
  uint32_t sphere = kNoMedium;
  std::vector<uint32_t> triangles;
  double volume = 0;  // negative: it faces inward
  Bounds box;
};

// Of the materials that transmit light. Of two cubes that share an edge or a face each is a surface of its own.
std::vector<Surface> closedSurfaces(const Scene& scene);

}  // namespace turner::nested_dielectrics
