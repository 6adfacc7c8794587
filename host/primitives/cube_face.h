// A face of the cube of directions around a point: projections of boxes and primitives onto it, conservative in
// spite of rounding. Coordinates u and v are those of gpu::LightBufferFace.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "base/bounds.h"

namespace turner {

// By how much the kernel may miss a cell, in u and v: its division is good to 2.5 ulp, its products to half of one.
inline constexpr float kCellRounding = 0x1p-19f;

// A rectangle on a face.
struct FaceRect {
  float uLo, uHi, vLo, vHi;
  bool overlaps(const FaceRect& other) const {
    return uLo <= other.uHi && other.uLo <= uHi && vLo <= other.vHi && other.vLo <= vHi;
  }
  FaceRect dilated() const {
    return {uLo - kCellRounding, uHi + kCellRounding, vLo - kCellRounding, vHi + kCellRounding};
  }
  FaceRect quarter(int i) const {
    const float u = 0.5f * (uLo + uHi), v = 0.5f * (vLo + vHi);
    return {i & 1 ? u : uLo, i & 1 ? uHi : u, i & 2 ? v : vLo, i & 2 ? vHi : v};
  }
};

// Lines around the projection of a primitive: where x u + y v + z < 0 for one of them, it is not.
using OuterEdges = std::array<glm::vec3, 4>;

// Of a pair: the first triangle has 0, 1, 2, the second 3, 1, 2. A single triangle repeats 1 as 3: one edge is a point.
using Corners = std::array<glm::dvec3, 4>;

// A box seen from the point.
struct Projection {
  FaceRect rect;   // on the face
  float distance;  // least along the face's axis
};

class CubeFace {
 public:
  // `face`: in the order of gpu::LightBufferFace.
  CubeFace(const glm::dvec3& point, int face) : point_(point), axis_(face / 2), negative_(face % 2 == 1) {}

  // A point as it is seen: along u, v and the face's axis, so that u and v are the quotients by the last.
  glm::dvec3 seen(const glm::dvec3& p) const {
    const glm::dvec3 d = negative_ ? point_ - p : p - point_;
    return {d[(axis_ + 1) % 3], d[(axis_ + 2) % 3], d[axis_]};
  }

  // False if the box lies behind the point; `out` is then unchanged.
  bool project(const Box& box, Projection& out) const;

  // The outer edges of a pair whose padded box was projected. Edges that cannot be bounded are left as they are; zeros
  // exclude nothing.
  void projectEdges(const Corners& corners, const Box& box, OuterEdges& edges) const;

 private:
  glm::dvec3 point_;
  int axis_;
  bool negative_;
};

}  // namespace turner
