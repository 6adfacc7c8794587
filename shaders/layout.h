// What crosses the border between host and shader: structures, ids of constants and bindings, and the bits of
// references. Read by C++ (as namespace turner::gpu) and by GLSL; interface.h lists the constants and bindings.
//
// Memory is made of words of 16 bytes, Word4: each vec3 is followed by a scalar, so that std430 and C++ agree without a
// device feature. Blocks (Frame, Tile, Status) are read by their members; the structures of the scene stand in scene.h,
// with their loads.
#ifndef TURNER_LAYOUT_H
#define TURNER_LAYOUT_H

#ifdef __cplusplus
#include <cstdint>
namespace turner::gpu {
using uint = uint32_t;
struct vec2 {
  float x, y;
};
struct vec3 {
  float x, y, z;
};
struct uvec3 {
  uint x, y, z;
};
struct uvec4 {
  uint x, y, z, w;
};
using Word4 = uvec4;
#define TURNER_CONST inline constexpr uint
#else
#define Word4 uvec4
#define TURNER_CONST const uint
#endif

// --- references -----------------------------------------------------------------------------------------------------
// Traversal reference: the index of an inner node, or a leaf of 1 to kMaxLeafSize consecutive primitives of one type. A
// primitive is a sphere, a cone or a pair of triangles.
//   bit 31: leaf | bit 30: triangle pairs | bits 29..28: primitives, less 1 | bit 27: of triangle pairs: the first
//   triangle of the first pair was tested already (resumed traversal); else: cones, not spheres | bits 26..0: offset of
//   the first
// Offsets count units of kUnitWords words.
TURNER_CONST kRefLeaf = 0x80000000u;
TURNER_CONST kRefTriangle = 0x40000000u;
TURNER_CONST kRefCountShift = 28u;
TURNER_CONST kRefCountMask = 3u;
TURNER_CONST kRefSecond = 0x08000000u;
TURNER_CONST kRefOffsetMask = 0x07ffffffu;
TURNER_CONST kRefNone = 0xffffffffu;  // nothing is left to visit
TURNER_CONST kRefNext = 0xfffffffeu;  // sentinel: pop the stack; if it is empty, take the next entry of the cell list
TURNER_CONST kMaxLeafSize = 4u;
TURNER_CONST kUnitWords = 2u;
TURNER_CONST kSphereUnits = 1u, kPairUnits = 3u;
TURNER_CONST kMaxUnits = 0x07fffff0u;  // so that no leaf reads as kRefNone or kRefNext
// One sphere or triangle uses bits 30 and 27..0 likewise. Of a ray's origin primitive bit 29 says that the ray starts
// toward the inside of a sphere or cone.
TURNER_CONST kRefPrimitive = kRefTriangle | kRefSecond | kRefOffsetMask;
TURNER_CONST kStartsInward = 0x20000000u;

// Deepest path of inner nodes; the builder keeps to it, the traversal's stack has room for it.
TURNER_CONST kMaxTreeDepth = 48u;

// --- bounded work (docs/kernel.md) ----------------------------------------------------------------------------------
// lavapipe ends all loops of an invocation after 65,535 iterations, silently, counting those that any lane of its SIMD
// unit makes. All lanes of a unit together make at most kIterations in one dispatch; each has its share.
TURNER_CONST kIterations = 56000u;
TURNER_CONST kCanaryLength = 4u;  // iterations of the loop that tells whether the limiter fired

// --- samplers, as the kernel numbers them ---------------------------------------------------------------------------
TURNER_CONST kGrid = 0u;
TURNER_CONST kJitter = 1u;
TURNER_CONST kSobol = 2u;
// Hashed instead of a sample's index where all samples of a pixel share the random words; beyond every index.
TURNER_CONST kStripSeed = 0x10000u;

// --- ids of specialisation constants, and bindings ------------------------------------------------------------------
TURNER_CONST kSpecWorkGroup = 0u;
#ifdef __cplusplus
#define TURNER_CONSTANT(Name, id, type, NAME, value) TURNER_CONST kSpec##Name = id;
#else
#define TURNER_CONSTANT(Name, id, type, NAME, value) \
  TURNER_CONST kSpec##Name = id;                     \
  layout(constant_id = id) const type NAME = value;
#endif
#define TURNER_FEATURE(Name, id, type, NAME, value, member) TURNER_CONSTANT(Name, id, type, NAME, value)
#define TURNER_BLOCK(Name, id, access, Type, variable, extent, what) TURNER_CONST kBind##Name = id;
#define TURNER_ARRAY(Name, id, variable, what) TURNER_CONST kBind##Name = id;
#include "interface.h"
#ifdef __cplusplus
#define TURNER_CONSTANT(...) +1u
#define TURNER_FEATURE(...) +1u
inline constexpr uint kSpecCount = 1u
#include "interface.h"
    ;
#define TURNER_BLOCK(...) +1u
#define TURNER_ARRAY(...) +1u
inline constexpr uint kBindCount = 0u
#include "interface.h"
    ;
#endif

// --- blocks ---------------------------------------------------------------------------------------------------------
TURNER_CONST kMostParameters = 32u;

// The picture: camera and what else is the same for all pixels. The direction through the point (px, py), in pixels
// from the top left of the full picture, is centre + (px - width/2) * right + (py - height/2) * down; each vector is
// the unevaluated sum of two floats. The eye is the origin.
struct Frame {
  vec3 centreHi;
  uint root;  // of the tree, a reference
  vec3 centreLo;
  uint width;  // of the full picture, pixels
  vec3 rightHi;
  uint height;
  vec3 rightLo;
  uint seed;
  vec3 downHi;
  float minWeight;  // rays of less are not spawned
  vec3 downLo;
  uint threads;  // of a CPU device, which get contiguous shares of a dispatch; 1 elsewhere
  // Of the scene's coordinates: local = (world - worldEye) * worldScale, a power of two (world.glsl).
  vec3 worldEyeHi;
  float worldScale;
  vec3 worldEyeLo;
  uint padding;
  vec3 background;
  uint canaryLength;   // kCanaryLength, where no compiler knows it
  uvec4 media;         // that the eye is in (nested_dielectrics.glsl)
  uvec4 addresses[6];  // x, y: of the arrays from kBindNodes on, where the kernel reads by device address
  // The values of PARAM(type, name, ...), in the order of their declarations, which the host turns into loads.
  uvec4 parameters[32];
};

// A tile of the picture, and the part of it that one dispatch works on; push constants. They decide no branch by
// themselves: lavapipe would compile the kernel anew for each value of one that does.
struct Tile {
  uint x0, y0;         // pixel at its top left, in the full picture
  uint width, height;  // pixels
  uint slots;          // invocations that the tile has state for: its 8x8 blocks times 64
  uint firstGroup;     // work-groups that came before this dispatch
  uint groups;         // work-groups of this dispatch
  uint stride;         // pixels from one of the tile's to the next, across and down: 1, or more for a coarse picture
};

// What the host reads after a dispatch.
struct Status {
  uint unfinished;      // invocations that have work left
  uint limiter;         // invocations whose canary loop was cut: a driver's loop limiter fired
  uint samplesWaiting;  // samples that they have not yet finished
  uint mediaLost;  // invocations with a ray that was in more than kMaxMedia media, or passed too many hidden interfaces
  uint lacks;      // of an edited kernel: bit kSpec<Name> where it needs more of a constant than it has (edited.glsl)
  uint padding0, padding1, padding2;
};

// --- the invocations' state (resume.glsl) ---------------------------------------------------------------------------
// The fourth word of a pixel that is finished; other values are path states (resume.glsl).
TURNER_CONST kPixelDone = 5u;

// An invocation that has work left at the end of its dispatch keeps it here; word r of slot s is state[r * slots + s].
TURNER_CONST kStateRays = 7u;        // counted: eye, reflected, refracted, shadow
TURNER_CONST kStateNodes = 8u;       // nodes visited by each kind of ray
TURNER_CONST kStatePrimitives = 9u;  // primitives tested by each kind of ray
TURNER_CONST kStateNodeStack = 10u;  // kMaxTreeDepth references, four in a word
TURNER_CONST kStateFirstCone = 26u;  // of the cell list, where there are cones
TURNER_CONST kStateRayStack = 27u;   // of each level from 2 on: two words, three where there are nested dielectrics
TURNER_CONST kEditWords = 8u;        // of an edited kernel: behind all of these, for its global variables
TURNER_CONST kMaxHiddenInterfaces = 65536u;  // that a ray may pass before its next hit

#ifdef __cplusplus
// Words of an invocation's state.
inline constexpr uint stateWords(uint depth, bool nestedDielectrics, bool edited) {
  return kStateRayStack + (nestedDielectrics ? 3 : 2) * (depth - 1) + (edited ? kEditWords : 0);
}
static_assert(sizeof(Word4) == 16);
static_assert(sizeof(Frame) == 256 + 16 * kMostParameters);
static_assert(sizeof(Tile) == 32);
static_assert(sizeof(Status) == 32);
}  // namespace turner::gpu
#endif
#undef TURNER_CONST

#ifdef __cplusplus
#include "scene.h"
#endif
#endif
