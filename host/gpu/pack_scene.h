// From a scene to what the kernel reads: rounded, in the order of the tree's leaves, in rows of layout.h.
#pragma once

#include <vector>

#include "accel/bvh.h"
#include "accel/light_buffer.h"
#include "geometry/prepared_geometry.h"
#include "geometry/round_scene.h"
#include "image/settings.h"
#include "kernel/features.h"
#include "layout.h"
#include "scene/scene.h"

namespace turner {

// What all rays see.
struct View {
  Camera camera;  // in the local frame, its eye the origin
  glm::dvec3 background{0};
  gpu::uvec4 media{};              // that the eye is in
  gpu::uint root = gpu::kRefNone;  // of the tree
  // The picture that the eye's lists are made for: a picture of this size, and pixels of this part of it.
  int width = 0, height = 0;
  Window crop;
};

struct PackedScene {
  std::vector<gpu::Node> nodes;
  std::vector<gpu::Word4> primitives;  // gpu::Sphere and gpu::Triangle, in the order of the leaves
  std::vector<gpu::VertexNormals> vertexNormals;
  std::vector<gpu::Word4> materials;  // gpu::Material, then gpu::NearSphere
  std::vector<gpu::Light> lights;
  std::vector<gpu::Word4> lightBuffers;  // of the eye and of each light
  View view;
  Features features;
  int treeDepth = 0;
  size_t primitiveCount = 0;
  size_t bytes() const;  // of geometry, tree and cubes on the device
};

// How rays through the eye and the lights begin: along lists that are made for them, or at the root as all others do.
// Mixed lists are for a kernel that can visit nodes in every walk, whether the scene needs it or not.
enum class TraversalStart { lists, mixedLists, wholeTree };

// The place of each sphere and then of each triangle in the order in which they are hit where a ray meets several at
// one distance: what is opaque, then glass that is no overlapping solid, then those of highest priority first; each by
// ids.
std::vector<gpu::uint> tieBreakRanks(const PreparedGeometry& prepared);

// `bvh` is built over the geometry's boxes. The settings tell how many rays will come through the
// eye, and where; they do not change the picture. Throws InputError if there are more primitives than a reference can
// name, or more overlapping solids than the kernel can number, or more of them around the eye than a ray can be in;
// RunError if the tree is deeper than the kernel's stack.
PackedScene packScene(const PreparedGeometry& prepared, const Bvh& bvh, const RenderSettings& settings,
                      TraversalStart start = TraversalStart::lists);

// What the kernel needs of the view and the settings.
gpu::Frame packFrame(const View& view, const RenderSettings& settings, uint32_t deviceThreads);

}  // namespace turner
