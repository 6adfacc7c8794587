// Solids of glass that overlap or touch (docs/light_transport.md). A ray carries the set of those that it is in; of these
// the one with the highest number is seen, and the others' walls are hidden (Schmidt and Budge, Journal of Graphics Tools
// 7(2), 2002). A solid's number is that of its material.

// Eight numbers, two in a word; 0: none, as the first material is never a solid's.
const uint kHalf = 0xffffu;

bool solidsLost;  // a ray was in more solids than there is room for

// The solid that is seen where a ray is in these, or 0 for air.
uint seenOf(const uvec4 solids) {
  uvec4 most = max(solids & kHalf, solids >> 16u);
  return max(max(most.x, most.y), max(most.z, most.w));
}

uvec4 withoutSolid(const uvec4 solids, const uint solid) {
  uvec4 low = solids & kHalf, high = solids >> 16u;
  return mix(low, uvec4(0u), equal(low, uvec4(solid))) | (mix(high, uvec4(0u), equal(high, uvec4(solid))) << 16u);
}

// In the first place that is free.
uvec4 withSolid(const uvec4 solids, const uint solid) {
  uvec4 others = withoutSolid(solids, solid);
  uvec4 freeLow = uvec4(equal(others & kHalf, uvec4(0u))) * uvec4(1u, 2u, 4u, 8u);
  uvec4 freeHigh = uvec4(equal(others >> 16u, uvec4(0u))) * uvec4(16u, 32u, 64u, 128u);
  uvec4 places = freeLow + freeHigh;
  uint place = uint(findLSB(places.x + places.y + places.z + places.w));
  solidsLost = solidsLost || place >= kMaxSolids;
  uint moved = solid << (place >= 4u ? 16u : 0u);
  return others | mix(uvec4(0u), uvec4(moved), equal(uvec4(0u, 1u, 2u, 3u), uvec4(place & 3u)));
}

// What a ray is in behind a wall, of what it is in before: a hit on the front enters, one on the back leaves.
uvec4 behindWall(const uvec4 solids, const uint solid, const bool front) {
  return front ? withSolid(solids, solid) : withoutSolid(solids, solid);
}

// What a solid is made of, 0 for air: the row of its material that holds its index of refraction and its glass.
Row mediumOf(const uint solid) {
  Row row = ROW(materials, kMaterialRows * solid + kMaterialOther);
  return solid == 0u ? Row(0u, floatBitsToUint(1.0), 0u, 0u) : row;
}

// A ray's way through a wall.
struct Crossing {
  uvec4 beyond;  // the solids that it is in behind
  bool hidden;   // there is the same glass on both sides: the wall is not there
  vec2 n;        // index of refraction behind over that before, the sum of two floats
};

// The ray is in `solids`, and hits `surface`; where it meets another wall in the same place, that is `other`: both act as
// one. The sets are what is true: to enter a solid once more, or to leave it again, changes nothing.
Crossing crossWall(const uvec4 solids, const Surface surface, const bool meetsOther, const Surface other) {
  Row material = ROW(materials, kMaterialRows * surface.material + kMaterialOther);
  Row otherMaterial = ROW(materials, kMaterialRows * other.material + kMaterialOther);
  bool isSolid = material.w != 0u, otherIsSolid = meetsOther && otherMaterial.w != 0u;
  uvec4 beyond = solids;
  // A thin edge may be met on both sides at once: in the end the ray is out.
  if (isSolid && surface.front) beyond = withSolid(beyond, surface.material);
  if (otherIsSolid) beyond = behindWall(beyond, other.material, other.front);
  if (isSolid && !surface.front) beyond = withoutSolid(beyond, surface.material);
  Row before = mediumOf(seenOf(solids)), behind = mediumOf(seenOf(beyond));
  // What is no solid that matters: glass on its back, on its front whatever is there.
  uint ownIndex = material.y;
  if (!isSolid) {
    before.y = surface.front ? before.y : ownIndex;
    behind.y = surface.front ? ownIndex : behind.y;
  }
  vec2 n = wideProduct(vec2(uintBitsToFloat(behind.y), 0), wideReciprocal(uintBitsToFloat(before.y)));
  return Crossing(beyond, isSolid && before.w == behind.w, n);
}
