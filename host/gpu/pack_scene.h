// From a scene to what the kernel reads: rounded, in the order of the tree's leaves, in rows of layout.h.
#pragma once

#include <vector>

#include "accel/bvh.h"
#include "accel/light_buffer.h"
#include "geometry/prepared_geometry.h"
#include "geometry/round_scene.h"
#include "gpu/pack_view.h"
#include "image/settings.h"
#include "layout.h"
#include "scene/scene.h"

namespace turner {

struct PackedScene {
  std::vector<gpu::Node> nodes;
  std::vector<gpu::Word4> primitives;  // gpu::Sphere and gpu::TrianglePair, in the order of the leaves
  std::vector<gpu::VertexNormals> vertexNormals;
  std::vector<gpu::Word4> materials;  // gpu::Material, then gpu::NearSphere
  std::vector<gpu::Light> lights;
  std::vector<gpu::Word4> lightBuffers;  // of the eye and of each light
  View view;
  Features features;
  int treeDepth = 0;
  size_t primitiveCount = 0;
  size_t bytes() const;         // of geometry, tree and light buffers on the device
  size_t largestArray() const;  // bytes
};

// Where eye and shadow rays start traversal: in the cell lists, or at the root as all others do (tests, measurements).
// Mixed lists are for a kernel that can visit nodes in every traversal, whether the scene needs it or not (tests).
enum class TraversalStart { lists, mixedLists, wholeTree };

// Tie-break ranks of the spheres, then of the triangles: among hits at equal distance the smallest rank wins. Opaque
// primitives come first, then glass that is no overlapping solid, then overlapping solids by falling priority; each by
// ids.
std::vector<gpu::uint> tieBreakRanks(const PreparedGeometry& prepared);

// `bvh` is built over the geometry's boxes. The settings tell how many rays will come through the eye, and where; they
// do not change the picture. Throws InputError if there are more primitives than a reference can name, or more
// overlapping solids than the kernel can number, or more of them around the eye than a ray can be in; RunError if the
// tree is deeper than the kernel's stack.
PackedScene packScene(const PreparedGeometry& prepared, const Bvh& bvh, const RenderSettings& settings,
                      TraversalStart start = TraversalStart::lists);

}  // namespace turner
