// Solids of glass that overlap or touch (docs/light_transport.md). A ray carries the set of those that it is in; of these
// the one with the highest number is seen, and the others' walls are hidden (Schmidt and Budge, Journal of Graphics
// Tools 7(2), 2002). A solid's number is that of its material.

// Sets have room for eight numbers, two in a word; 0: none, as the first material is never a solid's.
const uint kHalf = 0xffffu;

bool solidsLost;  // a ray was in more solids than there is room for

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

// In the first free place; a set that is full stays as it is.
uvec4 with(const uvec4 set, const uint number, out bool full) {
  uvec4 others = without(set, number);
  uint free = freePlaces(others);
  full = free == 0u;
  return full ? set : others | atPlace(uint(findLSB(free)), number);
}

// --- walls ---
// A wall is a solid and the side of it that a ray meets. All walls that it meets in one place make a set; more than eight
// meet in a corner of many solids at the most, and what is too much there is left out.
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

// What a solid is made of, 0 for air: the row of its material that holds its index of refraction and its glass.
Row mediumOf(const uint solid) {
  Row row = ROW(materials, kMaterialRows * solid + kMaterialOther);
  return solid == 0u ? Row(0u, floatBitsToUint(1.0), 0u, 0u) : row;
}

// A ray's way through all walls in one place.
struct Crossing {
  uvec4 beyond;  // the solids that it is in behind them
  bool hidden;   // there is the same glass on both sides: no wall is to be seen
  vec2 n;        // index of refraction behind over that before, the sum of two floats
};

// The ray is in `solids` and meets `walls` on a surface of this material. The sets are what is true: to enter a solid once
// more, or to leave it again, changes nothing.
Crossing crossWalls(const uvec4 solids, const uvec4 walls, const Row material, const bool front) {
  uvec4 beyond = solids;
  // At a thin edge a ray may meet both sides of a solid at once: in the end it is out.
  uint i = 0u;
  do {
    uint wall = numberAt(walls, i);
    if ((wall & kWallFront) != 0u) beyond = withSolid(beyond, wall & ~kWallFront);
    ++i;
  } while (i < kMaxWalls && numberAt(walls, i) != 0u);
  i = 0u;
  do {
    uint wall = numberAt(walls, i);
    if (wall != 0u && (wall & kWallFront) == 0u) beyond = without(beyond, wall);
    ++i;
  } while (i < kMaxWalls && numberAt(walls, i) != 0u);

  Row before = mediumOf(seenOf(solids)), behind = mediumOf(seenOf(beyond));
  bool isSolid = material.w != 0u;
  // What is no solid that matters: glass on its back, on its front whatever is there.
  if (!isSolid) {
    before.y = front ? before.y : material.y;
    behind.y = front ? material.y : behind.y;
  }
  vec2 n = wideProduct(vec2(uintBitsToFloat(behind.y), 0), wideReciprocal(uintBitsToFloat(before.y)));
  return Crossing(beyond, isSolid && before.w == behind.w, n);
}
