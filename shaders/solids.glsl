// Solids of glass that overlap or touch (docs/light_transport.md). A ray carries the set of those that it is in; of these
// the one with the highest number is seen, and the others' walls are hidden (Schmidt and Budge, Journal of Graphics
// Tools 7(2), 2002). A solid's number is that of its material.

// Sets have room for eight numbers, two in a word; 0: none, as the first material is never a solid's.
const uint kHalf = 0xffffu;

bool solidsLost;  // a ray was in more solids, or met more walls in one place, than there is room for

// Bit i: place i of a set is free.
uint freePlaces(const uvec4 set) {
  uvec4 bits = uvec4(equal(set & kHalf, uvec4(0u))) * uvec4(1u, 2u, 4u, 8u) +
               uvec4(equal(set >> 16u, uvec4(0u))) * uvec4(16u, 32u, 64u, 128u);
  return bits.x + bits.y + bits.z + bits.w;
}

// A set with this number at this place, and nothing else.
uvec4 atPlace(const uint place, const uint number) {
  uint moved = number << (place >= 4u ? 16u : 0u);
  return mix(uvec4(0u), uvec4(moved), equal(uvec4(0u, 1u, 2u, 3u), uvec4(place & 3u)));
}

uint numberAt(const uvec4 set, const uint place) {
  uint i = place & 3u, word = i < 2u ? (i == 0u ? set.x : set.y) : (i == 2u ? set.z : set.w);
  return place >= 4u ? word >> 16u : word & kHalf;
}

uvec4 without(const uvec4 set, const uint number) {
  uvec4 low = set & kHalf, high = set >> 16u;
  return mix(low, uvec4(0u), equal(low, uvec4(number))) | (mix(high, uvec4(0u), equal(high, uvec4(number))) << 16u);
}

bool has(const uvec4 set, const uint number) {
  return any(equal(set & kHalf, uvec4(number))) || any(equal(set >> 16u, uvec4(number)));
}

// In the first free place; a set that is full stays as it is.
uvec4 with(const uvec4 set, const uint number, out bool full) {
  uvec4 others = without(set, number);
  uint free = freePlaces(others);
  full = free == 0u;
  return full ? set : others | atPlace(uint(findLSB(free)), number);
}

// --- walls ---
// A wall is a solid and the side of it that a ray meets. All walls that it meets in one place make a set.
const uint kMaxWalls = 8u;
const uint kWallFront = 0x8000u;  // the ray enters the solid

// The wall of a material, or 0 where that is no solid's.
uint wallOf(const uint material, const bool front) {
  Row other = ROW(materials, kMaterialRows * material + kMaterialOther);
  return other.w == 0u ? 0u : material | (front ? kWallFront : 0u);
}

uvec4 withWall(const uvec4 walls, const uint wall) {
  bool full;
  uvec4 more = with(walls, wall, full);
  solidsLost = solidsLost || (full && wall != 0u);
  return wall == 0u ? walls : more;
}

// --- solids ---
// The solid that is seen where a ray is in these, or 0 for air.
uint seenOf(const uvec4 solids) {
  uvec4 most = max(solids & kHalf, solids >> 16u);
  return max(max(most.x, most.y), max(most.z, most.w));
}

uvec4 withSolid(const uvec4 solids, const uint solid) {
  bool full;
  uvec4 more = with(solids, solid, full);
  solidsLost = solidsLost || full;
  return more;
}
