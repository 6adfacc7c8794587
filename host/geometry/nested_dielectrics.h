// Nested dielectrics: solids of glass that lie in one another, overlap or touch. Where a ray is in several of them, or
// hits coincident interfaces, priority decides which of the media is active. Lies below both the kernel's packer and
// the reference; knows nothing of rays. (Schmidt and Budge, Journal of Graphics Tools 7(2), 2002.)
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace turner {

// A solid is a sphere that transmits light, or triangles of one such material that enclose a volume: a closed,
// consistently oriented surface, in which each edge occurs equally often in both directions. Spheres and surfaces that
// face inward bound hollows in the smallest solid of their material whose bounds hold theirs.
inline constexpr uint32_t kNoMedium = UINT32_MAX;

struct NestedDielectrics {
  // The material of each solid whose bounds or surface meet those of another, or that something opaque lies on so that
  // only rounding separates them. In order of priority: where two overlap, the later one is active. It is the smaller
  // one by the volume within its outer surface; of equal ones that with the later primitives.
  std::vector<uint32_t> materials;
  // Of each solid a number that it shares with those of the same glass, whose materials are equal but for their names.
  std::vector<uint32_t> glasses;
  // Of each sphere and of each triangle the index in `materials`, or kNoMedium; empty where there are no such solids.
  std::vector<uint32_t> ofSpheres, ofTriangles;
  // Those that the camera's eye is in, ascending.
  std::vector<uint32_t> aroundEye;

  bool empty() const { return materials.empty(); }
};

// `scene` is the exact one, or the result of roundScene.
NestedDielectrics findNestedDielectrics(const Scene& scene);

// Whether any material transmits light.
bool hasGlass(const Scene& scene);

// The side of a triangle that is its front: 1 by its winding, -1 where its vertex normals look to the other side.
double facing(const Scene& scene, const Triangle& triangle);

}  // namespace turner
