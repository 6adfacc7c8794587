// An open truncated cone, or a cylinder: its bounds, its rounding for the kernel, its packed form, and its picture on a
// face of a cube of directions. The kernel's part is shaders/cone.glsl.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "base/bounds.h"
#include "primitives/cube_face.h"
#include "primitives/local_frame.h"

namespace turner {

struct Features;

namespace gpu {
struct Cone;
}  // namespace gpu

// The surface between two circles around one axis; no ends. Its front looks away from the axis.
struct Cone {
  glm::dvec3 base{0, 0, 0};
  double baseRadius = 1;  // both of one sign, not both 0; negative (NFF only): the front looks toward the axis
  glm::dvec3 apex{0, 1, 0};
  double apexRadius = 1;
  uint32_t material = 0;

  bool isInward() const { return baseRadius < 0 || apexRadius < 0; }
};

// A cone that is flatter than this, |difference of the radii| over length, is refused by the parsers: it is a disc.
inline constexpr double kFlattestCone = 1e5;

// Whether the ends are so near to each other, compared with the radii, that the kernel could not tell the cone from a
// disc with a hole.
bool isTooFlat(const Cone& cone);

Bounds boundsOf(const Cone& cone);

// Rounded to what the kernel computes with: radii, and the end of the lesser one, its anchor. So is the other end, that
// a cone or a sphere may share, unless the cone is wider than long: then that would tilt it, and the way from the
// anchor to there keeps its digits.
Cone toLocal(const Cone& world, const LocalFrame& frame);

// Whether float32 can hold it; of a local cone, as all below.
bool isWithinReach(const Cone& local);

// Whether the cone is so many radii away from the eye that float32 is short of digits for where rays pass it.
bool isFarFromEye(const Cone& local);

// Sine of the angle between axis and surface: 0 for a cylinder, near 1 for what is almost a disc.
double slopeOf(const Cone& local);

uint32_t referenceType(const Cone&);  // type bits of a reference of the kernel
gpu::Cone packed(const Cone& local, uint32_t rank);

// Notes what such a primitive needs of the kernel.
void addFeatures(const Cone& local, Features& features);

// From its padded box to its own picture on the face: narrows the projection, and bounds it by edges. Both stay as they
// are where part of the cone lies behind the point.
void narrow(const Cone& local, const CubeFace& face, const Box& box, Projection& projection, OuterEdges& edges);

}  // namespace turner
