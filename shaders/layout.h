// What crosses the border between host and shader: structures, bindings, specialisation constants and the bits of
// references. Read by C++ (as namespace turner::gpu) and by GLSL.
//
// Everything is made of 16-byte rows: three floats and a fourth word, which is a float or an unsigned integer as the
// comment says. In GLSL a row is a uvec4, so that one fetch is one load of four words and integers keep their bits;
// xyz() and uintBitsToFloat() turn them into floats. tests/test_layout.cpp holds the offsets of the compiled SPIR-V
// against the compiler's.
#ifndef TURNER_LAYOUT_H
#define TURNER_LAYOUT_H

#ifdef __cplusplus
#include <cstdint>
namespace turner::gpu {
using uint = uint32_t;
struct Row {
  float x, y, z;
  uint w;
};
#define TURNER_CONST inline constexpr uint
#else
#define Row uvec4
#define TURNER_CONST const uint
#endif

// --- references -----------------------------------------------------------------------------------------------------
// A child of a node: another node (its index), or a leaf: some primitives of one kind that lie side by side.
//   bit 31: leaf | bit 30: triangles, else spheres | bits 29..27: how many, less 1 | bits 26..0: index of the first
TURNER_CONST kRefLeaf = 0x80000000u;
TURNER_CONST kRefTriangle = 0x40000000u;
TURNER_CONST kRefCountShift = 27u;
TURNER_CONST kRefCountMask = 7u;
TURNER_CONST kRefIndexMask = 0x07ffffffu;
TURNER_CONST kRefNone = 0xffffffffu;
TURNER_CONST kMaxLeafSize = 8u;
TURNER_CONST kMaxPrimitivesOfAKind = 0x07fffff0u;  // so that no leaf reads as kRefNone
// One primitive uses bits 30 and 26..0 likewise. Where it is the one that a ray starts on, bit 29 says that the ray
// goes to the side of a sphere's centre.
TURNER_CONST kLeavesInward = 0x20000000u;

// Deepest path of inner nodes; the builder keeps to it, the traversal's stack has room for it.
TURNER_CONST kMaxTreeDepth = 48u;

// --- bounded work (docs/kernel.md) ----------------------------------------------------------------------------------
// lavapipe ends all loops of an invocation after 65,535 iterations, silently. One dispatch of an invocation makes at
// most kSegments * (kSteps + kLightTries + 1) iterations of its loops, and copies its node stack in and out.
TURNER_CONST kSegments = 32u;     // pieces of rays (eye, secondary or shadow) traced in one dispatch
TURNER_CONST kSteps = 1800u;      // nodes or primitives visited in one piece
TURNER_CONST kLightTries = 8u;    // lights looked at in search of one that faces the surface
TURNER_CONST kCanaryLength = 4u;  // iterations of the loop that tells whether the limiter fired

// --- specialisation constants ---------------------------------------------------------------------------------------
// Their ids; whitted.comp declares them.
TURNER_CONST kSpecWorkGroup = 0u;
TURNER_CONST kSpecDepth = 1u;    // levels of the ray tree
TURNER_CONST kSpecSamples = 2u;  // n of the n x n grid
TURNER_CONST kSpecLights = 3u;   // number of lights
TURNER_CONST kSpecSpheres = 4u;  // booleans from here: does the scene have ...
TURNER_CONST kSpecTriangles = 5u;
TURNER_CONST kSpecSmoothNormals = 6u;
TURNER_CONST kSpecHighlights = 7u;
TURNER_CONST kSpecReflection = 8u;
TURNER_CONST kSpecRefraction = 9u;
TURNER_CONST kSpecFalloff = 10u;   // a light with inverse-square fall-off
TURNER_CONST kSpecJitter = 11u;    // hashed positions instead of cell centres
TURNER_CONST kSpecCounters = 12u;  // count the rays
TURNER_CONST kSpecSegments = 13u;  // kSegments and kSteps; tests set others
TURNER_CONST kSpecSteps = 14u;

// --- bindings -------------------------------------------------------------------------------------------------------
TURNER_CONST kBindFrame = 0u;
TURNER_CONST kBindNodes = 1u;
TURNER_CONST kBindSpheres = 2u;
TURNER_CONST kBindTriangles = 3u;
TURNER_CONST kBindVertexNormals = 4u;
TURNER_CONST kBindMaterials = 5u;
TURNER_CONST kBindLights = 6u;
TURNER_CONST kBindState = 7u;
TURNER_CONST kBindPixels = 8u;
TURNER_CONST kBindStatus = 9u;
TURNER_CONST kBindCount = 10u;

// --- structures -----------------------------------------------------------------------------------------------------
// The picture: camera and what else is the same for all pixels. The direction through the point (px, py), in pixels
// from the top left of the full picture, is centre + (px - width/2) * right + (py - height/2) * down; each vector is
// the unevaluated sum of two floats. The eye is the origin.
struct Frame {
  Row centreHi;    // w: root of the tree, a reference
  Row centreLo;    // w: width of the full picture
  Row rightHi;     // w: height of the full picture
  Row rightLo;     // w: seed
  Row downHi;      // w: least weight of a ray (float)
  Row downLo;      // w: threads of a CPU device, which get contiguous shares of a dispatch; 1 elsewhere
  Row background;  // w: kCanaryLength
};

// A tile of the picture, and the part of it that one dispatch works on; push constants. They decide no branch by
// themselves: lavapipe would compile the kernel anew for each value of one that does.
struct Tile {
  uint x0, y0;         // pixel at its top left, in the full picture
  uint width, height;  // pixels
  uint slots;          // invocations that the tile has state for: its 8x8 blocks times 64
  uint firstGroup;     // work-groups that came before this dispatch
  uint groups;         // work-groups of this dispatch
  uint unused;
};

// Two children with their boxes, padded outward by the builder (Aila and Laine 2009 keep both boxes in the parent).
struct Node {
  Row lo0;  // w: reference of child 0
  Row hi0;  // w: reference of child 1
  Row lo1;  // w: unused
  Row hi1;  // w: unused
};

struct Sphere {
  Row center;  // w: radius (float); negative: the surface faces inward
  Row tags;    // x: id, y: material (integers in a row's float places, by their bits)
};

struct Triangle {
  Row v0;      // w: id
  Row v1;      // w: material
  Row v2;      // w: index of its vertex normals, or kRefNone
  Row normal;  // of its plane, N.x = w (a float): unit, counter-clockwise side, computed in double by the host
};

struct VertexNormals {
  Row n0, n1, n2;  // unit; w: unused
};

struct Material {
  Row diffuse;   // k_d; w: r (float)
  Row specular;  // k_s; w: t (float)
  Row other;     // shininess n, eta, w_local (floats); w: unused
};

struct Light {
  Row position;  // w: 1 if its fall-off is inverse-square
  Row color;     // E; w: unused
};

// What the host reads after a dispatch.
struct Status {
  uint unfinished;       // invocations that have work left
  uint limiter;          // invocations whose canary loop was cut: a driver's loop limiter fired
  uint samplesFinished;  // in this pass over the tile
  uint unused;
};

// --- rows of an invocation's state ----------------------------------------------------------------------------------
// An invocation that reaches the end of its dispatch keeps its work here; row r of slot s is state[r * slots + s]. All
// zero is a pixel not yet begun.
TURNER_CONST kStateSum = 0u;              // sum of radiance; w: phase | level << 8
TURNER_CONST kStateCompensation = 1u;     // of the sum; w: samples done
TURNER_CONST kStateRay = 2u;              // origin; w: primitive it leaves
TURNER_CONST kStateDirection = 3u;        // w: weight (float)
TURNER_CONST kStateTraced = 4u;           // origin of the ray being traced: that ray, or a shadow ray of its hit
TURNER_CONST kStateTracedDirection = 5u;  // w: light
TURNER_CONST kStateHit = 6u;        // x: t of the hit (float), y: primitive, z: reference to visit next, w: stack top
TURNER_CONST kStatePending = 7u;    // x, y: levels that have a ray waiting; z: t limit of the traversal (float)
TURNER_CONST kStateCounts = 8u;     // eye, reflected, refracted, shadow
TURNER_CONST kStateNodeStack = 9u;  // kMaxTreeDepth references, four in a row
TURNER_CONST kStateRayStack = 21u;  // two rows for each level from 2 on: origin, leaving; direction, weight

#ifdef __cplusplus
inline constexpr uint stateRows(uint depth) {
  return kStateRayStack + 2 * (depth - 1);
}
static_assert(kStateRayStack == kStateNodeStack + kMaxTreeDepth / 4);
static_assert(kSegments * (kSteps + kLightTries + 1) + 2 * kMaxTreeDepth + kCanaryLength <= 60000);
static_assert(sizeof(Row) == 16);
static_assert(sizeof(Frame) == 112);
static_assert(sizeof(Tile) == 32);
static_assert(sizeof(Node) == 64);
static_assert(sizeof(Sphere) == 32);
static_assert(sizeof(Triangle) == 64);
static_assert(sizeof(VertexNormals) == 48);
static_assert(sizeof(Material) == 48);
static_assert(sizeof(Light) == 32);
static_assert(sizeof(Status) == 16);
}  // namespace turner::gpu
#endif
#undef TURNER_CONST
#endif
