// What crosses the border between host and shader: structures, ids of constants and bindings, and the bits of
// references. Read by C++ (as namespace turner::gpu) and by GLSL; interface.h lists the constants and bindings.
//
// Memory is made of words of 16 bytes, Word4: each vec3 is followed by a scalar, so that std430 and C++ agree without a
// device feature. Blocks (Frame, Tile, Status) are read by their members; all other structures are loaded by scene.glsl.
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
// primitive is a sphere or a pair of triangles.
//   bit 31: leaf | bit 30: triangle pairs, else spheres | bits 29..28: primitives, less 1 | bit 27: the first triangle of
//   the first pair was tested already (resumed traversal) | bits 26..0: offset of the first
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
// toward the inside of a sphere.
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
  vec3 background;
  uint canaryLength;   // kCanaryLength, where no compiler knows it
  uvec4 media;         // that the eye is in (nested_dielectrics.glsl)
  uvec4 addresses[6];  // x, y: of the arrays from kBindNodes on, where the kernel reads by device address
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
};

// --- the scene ------------------------------------------------------------------------------------------------------
// A node of the tree: two children with their boxes (Aila and Laine 2009 keep both in the parent), each plane in a
// byte: plane = origin + byte * 2^(exponent - 127), rounded outward (Mahovsky and Wyvill 2006 encode boxes relative to
// their parent's). A node's inner child stands next to it; of two inner children the first.
struct Node {
  vec3 origin;
  // Those of x, y, z in bytes 0 to 2; byte 3: bit 0 and 1: child 0, child 1 is a leaf (never child 1 alone); of a second
  // leaf, which stands behind the first: bits 3..2: primitives, less 1, bit 4: triangle pairs.
  uint exponents;
  uvec3 planes;    // lo 0, hi 0, lo 1, hi 1: bytes of an integer for each axis
  uint reference;  // the one child reference that cannot be derived from the others
};

// Primitives stand in the order of the leaves. Tie-break: among hits at equal t the smallest rank wins; opaque ones come
// first, in the order of their ids, then glass.
struct Sphere {
  vec3 center;
  float radius;  // negative: the surface faces inward
  uint rank;
  uint material;    // with kNearEye where the eye is near the surface; then:
  uint nearSphere;  // word of its NearSphere in the array of materials
  float eyePower;   // |center|^2 - radius^2
};
TURNER_CONST kNearEye = 0x80000000u;

// What a sphere's center and the eye's power lose to float; behind the materials.
struct NearSphere {
  vec3 centerRest;
  float eyePowerRest;
};

// N.x = offset; N is unit, on the counter-clockwise side, both computed in double by the host.
struct Plane {
  vec3 normal;
  float offset;
};

// Two triangles that share an edge: v0 v1 v2 and v3 v2 v1, seen counter-clockwise from their fronts. One that is alone
// has v1 once more as v3, so that the other is a line and never hit.
struct TrianglePair {
  vec3 v0;
  uint rank0;  // of the first
  vec3 v1;
  uint material;  // of both
  vec3 v2;
  uint normals;  // index of the vertex normals of the first, those of the second are next; or kRefNone
  vec3 v3;
  uint rank1;  // of the second, or kRefNone
  Plane planes[2];
};

struct VertexNormals {
  vec3 n0;
  uint padding0;
  vec3 n1;
  uint padding1;
  vec3 n2;
  uint padding2;
};

struct Material {
  vec3 diffuse;         // k_d
  float reflectance;    // r
  vec3 specular;        // k_s
  float transmittance;  // t
  float shininess;      // n
  float eta;            // index of refraction
  float localWeight;    // w_local
  // Medium id for nested dielectrics, shared by those of the same glass; 0 if none. Every overlapping solid has its own
  // material; a larger material index has priority (nested_dielectrics.glsl).
  uint glass;
};
TURNER_CONST kMaxMedia = 8u;          // that a ray can be in at once
TURNER_CONST kMaxMaterials = 32768u;  // where media are numbered

struct Light {
  vec3 position;
  uint falloff;  // 1: inverse-square
  vec3 color;    // E
  uint padding;
};

// One face of the cube of directions around a point that many rays share: the eye, or a light. Coordinates on the face
// are u = a / c, v = b / c, where c is the coordinate along the face's axis and a, b the next two in cyclic order.
// Faces: +x, -x, +y, -y, +z, -z; the eye's, then each light's. Behind the faces stand coarse cells, fine cells and the
// lists, all in one array (host/accel/light_buffer).
struct LightBufferFace {
  vec2 corner;         // u, v
  float cellsPerUnit;  // coarse cells per unit of u and of v
  uint cells;          // coarse cells on a side, | 256 times the word of the first of them
};

struct CoarseCell {
  uint firstFineCell;  // its word
  uint side;           // fine cells on a side
  uint padding0, padding1;
};

// The cell list of a fine cell: entries, counted in halves of a word. They are sorted by distance; where lists hold no
// nodes, spheres come before triangle pairs.
struct FineCell {
  uint first, end;
  uint firstPair;
  uint padding;
};

struct ListEntry {
  uint reference;
  float distance;  // least distance along the face's axis of what it refers to
};

// Sizes in words, for the loads of scene.glsl.
TURNER_CONST kNodeWords = 2u, kSphereWords = 2u, kPairVertexWords = 4u, kVertexNormalsWords = 3u, kMaterialWords = 3u,
             kLightWords = 2u, kLightBufferFaces = 6u;

// --- the invocations' state (resume.glsl) ---------------------------------------------------------------------------
// The fourth word of a pixel that is finished; other values are path states (resume.glsl).
TURNER_CONST kPixelDone = 5u;

// An invocation that has work left at the end of its dispatch keeps it here; word r of slot s is state[r * slots + s].
TURNER_CONST kStateRays = 7u;        // counted: eye, reflected, refracted, shadow
TURNER_CONST kStateNodes = 8u;       // nodes visited by each kind of ray
TURNER_CONST kStatePrimitives = 9u;  // primitives tested by each kind of ray
TURNER_CONST kStateNodeStack = 10u;  // kMaxTreeDepth references, four in a word
TURNER_CONST kStateRayStack = 26u;   // of each level from 2 on: two words, three where there are nested dielectrics
TURNER_CONST kMaxHiddenInterfaces = 65536u;  // that a ray may pass before its next hit

#ifdef __cplusplus
// Words of an invocation's state.
inline constexpr uint stateWords(uint depth, bool nestedDielectrics) {
  return kStateRayStack + (nestedDielectrics ? 3 : 2) * (depth - 1);
}
static_assert(sizeof(Word4) == 16);
static_assert(sizeof(Frame) == 224);
static_assert(sizeof(Tile) == 32);
static_assert(sizeof(Status) == 16);
static_assert(sizeof(Node) == kNodeWords * sizeof(Word4));
static_assert(sizeof(Sphere) == kSphereUnits * kUnitWords * sizeof(Word4) && kSphereWords == kSphereUnits * kUnitWords);
static_assert(sizeof(NearSphere) == sizeof(Word4));
static_assert(sizeof(TrianglePair) == kPairUnits * kUnitWords * sizeof(Word4));
static_assert(sizeof(TrianglePair) == kPairVertexWords * sizeof(Word4) + 2 * sizeof(Plane));
static_assert(sizeof(VertexNormals) == kVertexNormalsWords * sizeof(Word4));
static_assert(sizeof(Material) == kMaterialWords * sizeof(Word4));
static_assert(sizeof(Light) == kLightWords * sizeof(Word4));
static_assert(sizeof(LightBufferFace) == sizeof(Word4));
static_assert(sizeof(CoarseCell) == sizeof(Word4) && sizeof(FineCell) == sizeof(Word4));
static_assert(2 * sizeof(ListEntry) == sizeof(Word4));
}  // namespace turner::gpu
#endif
#undef TURNER_CONST
#endif
