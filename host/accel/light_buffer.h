// Lists of what rays through one point can hit: the point is the eye or a light, the lists belong to the cells of a
// cube of directions around it. An item buffer (Weghorst, Hooper, Greenberg, ACM TOG 3(1), 1984) and a light buffer
// (Haines, Greenberg, IEEE CG&A 6(9), 1986) over a tree: a list holds primitives, or nodes where many primitives share
// a cell. shaders/light_buffer.glsl looks the lists up.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "accel/bvh.h"
#include "geometry/prepared_geometry.h"
#include "layout.h"

namespace turner {

// The part of a face that rays go through, in its coordinates (gpu::LightBufferFace); empty where hi < lo.
struct FaceWindow {
  double uLo = -1, uHi = 1, vLo = -1, vHi = 1;
};

struct LightBufferPoint {
  glm::dvec3 position{0};
  std::array<FaceWindow, 6> windows;  // in the order of gpu::LightBufferFace
  size_t rays = 0;                    // about how many will come: as many cells are worth their time
  // Points of equal kernelTraversal share one call site of traversal: if one needs to visit nodes, all can.
  int kernelTraversal = 0;
  bool traversalVisitsNodes = false;  // it visits nodes in any case, for other rays
};

struct LightBuffers {
  std::vector<gpu::Word4> rows;   // of all points, as the kernel reads them
  std::vector<bool> visitsNodes;  // for each point: whether its traversal in the kernel must be able to visit nodes
};

// What the lists refer to.
struct LightBufferTree {
  const PreparedGeometry& prepared;
  const Bvh& bvh;                         // over its boxes
  std::span<const gpu::uint> references;  // the kernel's, of single primitives, in the order of Bvh::order
};

// Works on all cores; the result does not depend on their number.
LightBuffers buildLightBuffers(std::span<const LightBufferPoint> points, const LightBufferTree& tree);

// The same interface with the whole tree in every list: for tests, and to measure what the lists are worth.
LightBuffers wholeTreeLightBuffers(std::span<const LightBufferPoint> points, const LightBufferTree& tree);

}  // namespace turner
