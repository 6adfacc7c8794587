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
// What a traversal visits: a node (its index), or a leaf: some shapes of one kind that lie side by side. A shape is a
// sphere or a pair of triangles.
//   bit 31: leaf | bit 30: pairs, else spheres | bits 29..28: how many, less 1 | bit 27: of the first pair only the
//   second triangle is left | bits 26..0: place of the first
// Places count units of kUnitRows rows.
TURNER_CONST kRefLeaf = 0x80000000u;
TURNER_CONST kRefTriangle = 0x40000000u;
TURNER_CONST kRefCountShift = 28u;
TURNER_CONST kRefCountMask = 3u;
TURNER_CONST kRefSecond = 0x08000000u;
TURNER_CONST kRefOffsetMask = 0x07ffffffu;
TURNER_CONST kRefNone = 0xffffffffu;  // nothing is left to visit
TURNER_CONST kRefNext = 0xfffffffeu;  // whatever the traversal's stack or its list holds next
TURNER_CONST kMaxLeafSize = 4u;
TURNER_CONST kUnitRows = 2u;
TURNER_CONST kSphereUnits = 1u, kPairUnits = 3u;
TURNER_CONST kMaxUnits = 0x07fffff0u;  // so that no leaf reads as kRefNone or kRefNext
// One sphere or triangle uses bits 30 and 27..0 likewise. Where it is the one that a ray starts on, bit 29 says that
// the ray goes to the side of a sphere's centre.
TURNER_CONST kRefPrimitive = kRefTriangle | kRefSecond | kRefOffsetMask;
TURNER_CONST kStartsInward = 0x20000000u;

// Deepest path of inner nodes; the builder keeps to it, the traversal's stack has room for it.
TURNER_CONST kMaxTreeDepth = 48u;

// --- bounded work (docs/kernel.md) ----------------------------------------------------------------------------------
// lavapipe ends all loops of an invocation after 65,535 iterations, silently, counting those that any lane of its SIMD
// unit makes. All lanes of a unit together make at most kIterations in one dispatch; each has its share.
TURNER_CONST kIterations = 56000u;
TURNER_CONST kCanaryLength = 4u;  // iterations of the loop that tells whether the limiter fired

// --- specialisation constants ---------------------------------------------------------------------------------------
// Their ids; features.glsl declares them, but for the size of a work-group.
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
TURNER_CONST kSpecFalloff = 10u;            // a light with inverse-square fall-off
TURNER_CONST kSpecSampler = 11u;            // where samples lie, kGrid, kJitter or kSobol; not a boolean
TURNER_CONST kSpecCounters = 12u;           // count rays, nodes and primitives
TURNER_CONST kSpecNearestNodes = 13u;       // traversals for the nearest hit meet nodes, not only primitives
TURNER_CONST kSpecShadowNodes = 14u;        // shadow rays do
TURNER_CONST kSpecBudget = 15u;             // iterations of an invocation's loops in one dispatch; not a boolean
TURNER_CONST kSpecFresh = 16u;              // the first pass over a tile: there is no work to take up; a boolean
TURNER_CONST kSpecNearSpheres = 17u;        // a sphere whose surface the eye is near; a boolean
TURNER_CONST kSpecFarSpheres = 18u;         // a sphere that is many radii away from the eye; a boolean
TURNER_CONST kSpecNestedDielectrics = 19u;  // media of glass that overlap or touch; a boolean
// The prime factors of n in ascending order, a byte each from the lowest on, in two words, as sobol needs them; else 0.
TURNER_CONST kSpecRadicesLow = 20u;
TURNER_CONST kSpecRadicesHigh = 21u;
TURNER_CONST kSpecCount = 22u;

// Samplers, as the kernel numbers them.
TURNER_CONST kGrid = 0u;
TURNER_CONST kJitter = 1u;
TURNER_CONST kSobol = 2u;
// Hashed in place of a sample's index where all samples of a pixel share the random words; beyond every index.
TURNER_CONST kStripSeed = 0x10000u;

// --- bindings -------------------------------------------------------------------------------------------------------
TURNER_CONST kBindFrame = 0u;
TURNER_CONST kBindState = 1u;
TURNER_CONST kBindPixels = 2u;
TURNER_CONST kBindStatus = 3u;
// The scene, in rows that are read only: buffer_access.glsl says how.
TURNER_CONST kBindNodes = 4u;
TURNER_CONST kBindPrimitives = 5u;
TURNER_CONST kBindVertexNormals = 6u;
TURNER_CONST kBindMaterials = 7u;
TURNER_CONST kBindLights = 8u;
TURNER_CONST kBindLightBuffers = 9u;
TURNER_CONST kBindCount = 10u;

// --- structures -----------------------------------------------------------------------------------------------------
// The picture: camera and what else is the same for all pixels. The direction through the point (px, py), in pixels
// from the top left of the full picture, is centre + (px - width/2) * right + (py - height/2) * down; each vector is
// the unevaluated sum of two floats. The eye is the origin.
struct Frame {
  Row centreHi;      // w: root of the tree, a reference
  Row centreLo;      // w: width of the full picture
  Row rightHi;       // w: height of the full picture
  Row rightLo;       // w: seed
  Row downHi;        // w: least weight of a ray (float)
  Row downLo;        // w: threads of a CPU device, which get contiguous shares of a dispatch; 1 elsewhere
  Row background;    // w: kCanaryLength
  Row media;         // that the eye is in (nested_dielectrics.glsl)
  Row addresses[6];  // x, y: of the row arrays from kBindNodes on, where the kernel fetches by address
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

// A node of the tree: two children with their boxes (Aila and Laine 2009 keep both in the parent), each plane in a
// byte: plane = origin + byte * 2^(exponent - 127), rounded outward (Mahovsky and Wyvill 2006 encode boxes relative to
// their parent's). A node's inner child stands next to it; of two inner children the first.
//   exponents: those of x, y, z in bytes 0 to 2; byte 3: bit 0 and 1: child 0, child 1 is a leaf (never child 1 alone);
//   of a second leaf, which stands behind the first: bits 3..2: how many shapes, less 1, bit 4: pairs
struct Node {
  Row origin;  // w: exponents
  Row planes;  // x, y, z: lo 0, hi 0, lo 1, hi 1 (bytes of an integer); w: the reference that is neither next to it nor
               // behind the first leaf
};

// Shapes stand in the order of the leaves. Of primitives that a ray meets in one place, that of the lowest rank
// is hit: opaque ones come first, in the order of their ids, then glass.
struct Sphere {
  Row center;  // w: radius (float); negative: the surface faces inward
  // x: rank, y: material (integers in a row's float places, by their bits). Where the eye is near the surface
  // (kNearEye in y) z: row of its NearSphere among the materials, w (float): the eye's power |center|^2 - radius^2.
  Row tags;
};
TURNER_CONST kNearEye = 0x80000000u;

// What a sphere's center and the eye's power lose to float; behind the materials.
struct NearSphere {
  Row centerRest;  // w: rest of the power (float)
};

// Two triangles that share an edge: v0 v1 v2 and v3 v2 v1, seen counter-clockwise from their fronts. One that is alone
// has v1 once more as v3, so that the other is a line and never hit.
struct TrianglePair {
  Row v0;          // w: rank of the first
  Row v1;          // w: material of both
  Row v2;          // w: index of the vertex normals of the first, those of the second are next; or kRefNone
  Row v3;          // w: that of the second, or kRefNone
  Row normals[2];  // of their planes, N.x = w (a float): unit, counter-clockwise side, computed in double by the host
};

struct VertexNormals {
  Row n0, n1, n2;  // unit; w: unused
};

struct Material {
  Row diffuse;   // k_d; w: r (float)
  Row specular;  // k_s; w: t (float)
  // shininess n, eta, w_local (floats); w: 0, or of a medium that overlaps or touches another: a number that it shares
  // with others of the same glass. Every such medium has a material of its own, which stands behind those of all others
  // over which it has priority; its place is the medium's number (nested_dielectrics.glsl).
  Row other;
};
TURNER_CONST kMaxMedia = 8u;          // that a ray can be in at once
TURNER_CONST kMaxMaterials = 32768u;  // where media are numbered

struct Light {
  Row position;  // w: 1 if its fall-off is inverse-square
  Row color;     // E; w: unused
};

// One face of the cube of directions around a point that many rays share: the eye, or a light. Coordinates on the face
// are u = a / c, v = b / c, where c is the coordinate along the face's axis and a, b the next two in cyclic order.
// Faces: +x, -x, +y, -y, +z, -z; cubes: the eye's, then each light's. Behind the faces stand coarse cells, fine cells
// and the lists, all in one array of rows (host/shader/direction_cube).
struct LightBufferFace {
  Row window;  // u and v of its corner; z: coarse cells per unit of u and of v; w: coarse cells on a side, | 256 times
               // the row of the first of them
};
// A coarse cell is a row: row of its first fine cell, fine cells on a side. A fine cell is a row: its first entry, the
// end of its entries, its first pair. An entry is half a row: a reference, and the least distance along the face's
// axis (a float) of what it holds. They are sorted by that; where lists hold no nodes, spheres come before pairs.

// The kernel fetches rows one by one: their places in the structures above.
TURNER_CONST kNodeOrigin = 0u, kNodePlanes = 1u, kNodeRows = 2u;
TURNER_CONST kSphereCenter = 0u, kSphereTags = 1u;
TURNER_CONST kPairV0 = 0u, kPairV1 = 1u, kPairV2 = 2u, kPairV3 = 3u, kPairNormals = 4u;
TURNER_CONST kVertexNormalsRows = 3u;
TURNER_CONST kMaterialDiffuse = 0u, kMaterialSpecular = 1u, kMaterialOther = 2u, kMaterialRows = 3u;
TURNER_CONST kLightPosition = 0u, kLightColor = 1u, kLightRows = 2u;
TURNER_CONST kLightBufferRows = 6u;

// The fourth word of a pixel that is finished; other values say where its work stands (whitted.comp).
TURNER_CONST kPixelDone = 5u;

// What the host reads after a dispatch.
struct Status {
  uint unfinished;      // invocations that have work left
  uint limiter;         // invocations whose canary loop was cut: a driver's loop limiter fired
  uint samplesWaiting;  // samples that they have not yet finished
  uint mediaLost;  // invocations with a ray that was in more than kMaxMedia media, or passed too many hidden interfaces
};

// --- rows of an invocation's state ----------------------------------------------------------------------------------
// An invocation that has work left at the end of its dispatch keeps it here; row r of slot s is state[r * slots + s].
TURNER_CONST kStateSum = 0u;           // sum of radiance; w: kind | level << 8 | top of the node stack << 16
TURNER_CONST kStateCompensation = 1u;  // of the sum; w: samples done
TURNER_CONST kStateRay = 2u;           // origin; w: primitive it leaves
TURNER_CONST kStateDirection = 3u;     // w: weight (float)
TURNER_CONST kStateHit = 4u;  // x: t of the hit (float), y: primitive, z: light, w: first pair of the traversal's list
TURNER_CONST kStateTraversal =
    5u;                        // x: reference to visit next, y: t of the best hit (float), z: that primitive, w: its id
TURNER_CONST kStateList = 6u;  // x, y: rest of the traversal's list; z, w: levels that have a ray waiting
TURNER_CONST kStateRays = 7u;  // counted: eye, reflected, refracted, shadow
TURNER_CONST kStateNodes = 8u;           // nodes visited by each kind of ray
TURNER_CONST kStatePrimitives = 9u;      // primitives tested by each kind of ray
TURNER_CONST kStateNodeStack = 10u;      // kMaxTreeDepth references, four in a row
TURNER_CONST kStateMedia = 22u;          // that the ray in hand is in
TURNER_CONST kStateCoincident = 23u;     // interfaces that the traversal has gathered
TURNER_CONST kStateHitInterfaces = 24u;  // those in the place of the ray's hit
// Floats: x: where the place begins whose interfaces the traversal gathers, y: how far it reaches, w: t of the
// traversal's hit; z: hidden interfaces that the ray has passed.
TURNER_CONST kStateInterfaces = 25u;
// Rows for each level from 2 on: origin, leaving; direction, weight; where there are media: those that the ray is in.
TURNER_CONST kStateRayStack = 26u;
TURNER_CONST kMaxHiddenInterfaces = 65536u;  // that a ray may pass before its next hit

#ifdef __cplusplus
inline constexpr uint stateRows(uint depth, bool media) {
  return kStateRayStack + (media ? 3 : 2) * (depth - 1);
}
static_assert(kStateMedia == kStateNodeStack + kMaxTreeDepth / 4);
static_assert(sizeof(Row) == 16);
static_assert(sizeof(Frame) == 224);
static_assert(sizeof(Tile) == 32);
static_assert(sizeof(Node) == 32);
static_assert(sizeof(Sphere) == kSphereUnits * kUnitRows * sizeof(Row));
static_assert(sizeof(NearSphere) == 16);
static_assert(sizeof(TrianglePair) == kPairUnits * kUnitRows * sizeof(Row));
static_assert(sizeof(VertexNormals) == 48);
static_assert(sizeof(Material) == 48);
static_assert(sizeof(Light) == 32);
static_assert(sizeof(LightBufferFace) == 16);
static_assert(sizeof(Status) == 16);
}  // namespace turner::gpu
#endif
#undef TURNER_CONST
#endif
