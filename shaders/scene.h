// The scene as structures, and their loads. Read by C++, behind layout.h, and by GLSL, behind buffer_access.glsl: the
// only file of the kernel that loads words of the scene and casts their bits.
#ifndef TURNER_SCENE_H
#define TURNER_SCENE_H

#ifdef __cplusplus
namespace turner::gpu {
#define TURNER_CONST inline constexpr uint
#else
#define TURNER_CONST const uint

vec3 xyz(const Word4 word) {
  return uintBitsToFloat(word.xyz);
}
Word4 packWord(const vec3 v, const uint w) {
  return Word4(floatBitsToUint(v), w);
}
#endif

// A node of the tree: two children with their boxes (Aila and Laine 2009 keep both in the parent), each plane in a
// byte: plane = origin + byte * 2^(exponent - 127), rounded outward (Mahovsky and Wyvill 2006 encode boxes relative to
// their parent's). A node's inner child stands next to it; of two inner children the first.
struct Node {
  vec3 origin;
  // Those of x, y, z in bytes 0 to 2; byte 3: bit 0 and 1: child 0, child 1 is a leaf (never child 1 alone); of a
  // second leaf, which stands behind the first: bits 3..2: primitives, less 1, bit 4: triangle pairs, bit 5: cones.
  uint exponents;
  uvec3 planes;    // lo 0, hi 0, lo 1, hi 1: bytes of an integer for each axis
  uint reference;  // the one child reference that cannot be derived from the others
};
TURNER_CONST kNodeWords = 2u;
#ifndef __cplusplus
Node nodeAt(const uint index) {
  Word4 a = WORD4(nodes, kNodeWords * index), b = WORD4(nodes, kNodeWords * index + 1u);
  return Node(xyz(a), a.w, b.xyz, b.w);
}
#endif

// Primitives stand in the order of the leaves. Tie-break: among hits at equal t the smallest rank wins; opaque ones
// come first, in the order of their ids, then glass.
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
#ifndef __cplusplus
// Primitives are found by the offset in a reference, in units.
Sphere sphereAt(const uint offset) {
  Word4 a = WORD4(primitives, kUnitWords * offset), b = WORD4(primitives, kUnitWords * offset + 1u);
  return Sphere(xyz(a), uintBitsToFloat(a.w), b.x, b.y, b.z, uintBitsToFloat(b.w));
}

NearSphere nearSphereAt(const uint word) {
  Word4 a = WORD4(materials, word);
  return NearSphere(xyz(a), uintBitsToFloat(a.w));
}
#endif

// An open truncated cone. Its anchor is the end of the lesser radius. In long double by the host, then rounded once:
// base = radius there times the cosine of alpha, slope = sin(alpha), where alpha is half the angle at the tip. So what
// is nearly a disc is as well scaled as a cylinder.
struct Cone {
  vec3 anchor;
  float base;
  vec3 axis;   // unit
  float span;  // length along the axis
  uint rank;
  uint material;  // with kFarCone, kConeInward
  float reach;    // from the anchor to the farthest point, rounded up
  float slope;
  vec3 axisRest;  // what the axis loses to float
  float squaredCosine;
};
TURNER_CONST kConeUnits = 2u;
TURNER_CONST kRefCone = 0x08000000u;     // in references, where spheres have 0
TURNER_CONST kFarCone = 0x40000000u;     // many radii away from the eye: it takes the extra digits
TURNER_CONST kConeInward = 0x80000000u;  // the surface faces the axis
#ifndef __cplusplus
// The last word is read where a cone of the scene needs it.
Cone coneAt(const uint offset) {
  uint word = kUnitWords * offset;
  Word4 a = WORD4(primitives, word), b = WORD4(primitives, word + 1u), c = WORD4(primitives, word + 2u);
  Word4 rest = c;
  if (SLOPED_CONES || FAR_CONES) rest = WORD4(primitives, word + 3u);
  return Cone(xyz(a), uintBitsToFloat(a.w), xyz(b), uintBitsToFloat(b.w), c.x, c.y, uintBitsToFloat(c.z),
              SLOPED_CONES ? uintBitsToFloat(c.w) : 0.0, FAR_CONES ? xyz(rest) : vec3(0),
              SLOPED_CONES ? uintBitsToFloat(rest.w) : 1.0);
}
#endif

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
TURNER_CONST kPairVertexWords = 4u;  // before the planes
#ifndef __cplusplus
// A pair without its planes, which are rarely needed: planeAt loads one.
TrianglePair trianglePairAt(const uint offset) {
  uint word = kUnitWords * offset;
  Word4 a = WORD4(primitives, word), b = WORD4(primitives, word + 1u), c = WORD4(primitives, word + 2u),
        d = WORD4(primitives, word + 3u);
  Plane none = Plane(vec3(0), 0.0);
  return TrianglePair(xyz(a), a.w, xyz(b), b.w, xyz(c), c.w, xyz(d), d.w, Plane[2](none, none));
}

// The plane of a pair's first (0) or second (1) triangle. Where none is needed, the pair's first word is read once
// more, so that no other memory is touched.
Plane planeAt(const uint offset, const uint triangle, const bool needed) {
  uint word = kUnitWords * offset;
  Word4 a = WORD4(primitives, needed ? word + kPairVertexWords + triangle : word);
  return Plane(xyz(a), uintBitsToFloat(a.w));
}
#endif

struct VertexNormals {
  vec3 n0;
  uint padding0;
  vec3 n1;
  uint padding1;
  vec3 n2;
  uint padding2;
};
TURNER_CONST kVertexNormalsWords = 3u;
#ifndef __cplusplus
VertexNormals vertexNormalsAt(const uint index) {
  uint word = kVertexNormalsWords * index;
  return VertexNormals(xyz(WORD4(vertexNormals, word)), 0u, xyz(WORD4(vertexNormals, word + 1u)), 0u,
                       xyz(WORD4(vertexNormals, word + 2u)), 0u);
}
#endif

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
TURNER_CONST kMaterialWords = 3u;
#ifndef __cplusplus
Material materialAt(const uint index) {
  uint word = kMaterialWords * index;
  Word4 a = WORD4(materials, word), b = WORD4(materials, word + 1u), c = WORD4(materials, word + 2u);
  vec3 scalars = xyz(c);
  return Material(xyz(a), uintBitsToFloat(a.w), xyz(b), uintBitsToFloat(b.w), scalars.x, scalars.y, scalars.z, c.w);
}

// What a medium is made of: the index of refraction and the glass of its material; air for 0.
struct Medium {
  float eta;
  uint glass;
};
Medium mediumAt(const uint material) {
  Word4 c = WORD4(materials, kMaterialWords * material + 2u);
  return material == 0u ? Medium(1.0, 0u) : Medium(uintBitsToFloat(c.y), c.w);
}

uint glassAt(const uint material) {
  return WORD4(materials, kMaterialWords * material + 2u).w;
}
#endif

struct Light {
  vec3 position;
  uint falloff;  // 1: inverse-square
  vec3 color;    // E
  uint padding;
};
TURNER_CONST kLightWords = 2u;
#ifndef __cplusplus
Light lightAt(const uint index) {
#ifdef EDITED
  LACKS(Lights, index >= LIGHTS);
#endif
  Word4 a = WORD4(lights, kLightWords * index), b = WORD4(lights, kLightWords * index + 1u);
  return Light(xyz(a), a.w, xyz(b), 0u);
}
#endif

// One face of the cube of directions around a point that many rays share: the eye, or a light. Coordinates on the face
// are u = a / c, v = b / c, where c is the coordinate along the face's axis and a, b the next two in cyclic order.
// Faces: +x, -x, +y, -y, +z, -z; the eye's, then each light's. Behind the faces stand coarse cells, fine cells and the
// lists, all in one array (host/accel/light_buffer).
struct LightBufferFace {
  vec2 corner;         // u, v
  float cellsPerUnit;  // coarse cells per unit of u and of v
  uint cells;          // coarse cells on a side, | 256 times the word of the first of them
};
TURNER_CONST kLightBufferFaces = 6u;

struct CoarseCell {
  uint firstFineCell;  // its word
  uint side;           // fine cells on a side
  uint padding0, padding1;
};

// The cell list of a fine cell: entries, counted in halves of a word. They are sorted by distance; where lists hold no
// nodes, spheres come before cones, and those before triangle pairs.
struct FineCell {
  uint first, end;
  uint firstPair;
  uint firstCone;
};

struct ListEntry {
  uint reference;
  float distance;  // least distance along the face's axis of what it refers to
};
#ifndef __cplusplus
LightBufferFace faceAt(const uint index) {
  Word4 a = WORD4(lightBuffers, index);
  return LightBufferFace(uintBitsToFloat(a.xy), uintBitsToFloat(a.z), a.w);
}

CoarseCell coarseCellAt(const uint word) {
  Word4 a = WORD4(lightBuffers, word);
  return CoarseCell(a.x, a.y, 0u, 0u);
}

FineCell fineCellAt(const uint word) {
  Word4 a = WORD4(lightBuffers, word);
  return FineCell(a.x, a.y, a.z, a.w);
}

ListEntry listEntryAt(const uint index) {
  Word4 word = WORD4(lightBuffers, index >> 1u);
  uvec2 entry = (index & 1u) != 0u ? word.zw : word.xy;
  return ListEntry(entry.x, uintBitsToFloat(entry.y));
}
#endif

#ifdef __cplusplus
static_assert(sizeof(Node) == kNodeWords * sizeof(Word4));
static_assert(sizeof(Sphere) == kSphereUnits * kUnitWords * sizeof(Word4));
static_assert(sizeof(NearSphere) == sizeof(Word4));
static_assert(sizeof(Cone) == kConeUnits * kUnitWords * sizeof(Word4));
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
