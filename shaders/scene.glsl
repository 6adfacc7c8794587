// The scene as structures of layout.h: the only file that loads words and casts their bits. What a caller does not use
// of a structure the compiler does not load.

vec3 xyz(const Word4 word) { return uintBitsToFloat(word.xyz); }
Word4 packWord(const vec3 v, const uint w) { return Word4(floatBitsToUint(v), w); }

Node nodeAt(const uint index) {
  Word4 a = WORD4(nodes, kNodeWords * index), b = WORD4(nodes, kNodeWords * index + 1u);
  return Node(xyz(a), a.w, b.xyz, b.w);
}

// Primitives are found by the offset in a reference, in units.
Sphere sphereAt(const uint offset) {
  Word4 a = WORD4(primitives, kUnitWords * offset), b = WORD4(primitives, kUnitWords * offset + 1u);
  return Sphere(xyz(a), uintBitsToFloat(a.w), b.x, b.y, b.z, uintBitsToFloat(b.w));
}

NearSphere nearSphereAt(const uint word) {
  Word4 a = WORD4(materials, word);
  return NearSphere(xyz(a), uintBitsToFloat(a.w));
}

// A pair without its planes, which are rarely needed: planeAt loads one.
TrianglePair trianglePairAt(const uint offset) {
  uint word = kUnitWords * offset;
  Word4 a = WORD4(primitives, word), b = WORD4(primitives, word + 1u), c = WORD4(primitives, word + 2u),
        d = WORD4(primitives, word + 3u);
  Plane none = Plane(vec3(0), 0.0);
  return TrianglePair(xyz(a), a.w, xyz(b), b.w, xyz(c), c.w, xyz(d), d.w, Plane[2](none, none));
}

// The plane of a pair's first (0) or second (1) triangle. Where none is needed, the pair's first word is read once more,
// so that no other memory is touched.
Plane planeAt(const uint offset, const uint triangle, const bool needed) {
  uint word = kUnitWords * offset;
  Word4 a = WORD4(primitives, needed ? word + kPairVertexWords + triangle : word);
  return Plane(xyz(a), uintBitsToFloat(a.w));
}

VertexNormals vertexNormalsAt(const uint index) {
  uint word = kVertexNormalsWords * index;
  return VertexNormals(xyz(WORD4(vertexNormals, word)), 0u, xyz(WORD4(vertexNormals, word + 1u)), 0u,
                       xyz(WORD4(vertexNormals, word + 2u)), 0u);
}

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

uint glassAt(const uint material) { return WORD4(materials, kMaterialWords * material + 2u).w; }

Light lightAt(const uint index) {
  Word4 a = WORD4(lights, kLightWords * index), b = WORD4(lights, kLightWords * index + 1u);
  return Light(xyz(a), a.w, xyz(b), 0u);
}

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
  return FineCell(a.x, a.y, a.z, 0u);
}

ListEntry listEntryAt(const uint index) {
  Word4 word = WORD4(lightBuffers, index >> 1u);
  uvec2 entry = (index & 1u) != 0u ? word.zw : word.xy;
  return ListEntry(entry.x, uintBitsToFloat(entry.y));
}
