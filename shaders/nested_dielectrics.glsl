// Solids of glass that overlap or touch (docs/light_transport.md). A ray carries the set of those that it is in; of these
// the one with the highest number is seen, and the others' interfaces are hidden (Schmidt and Budge, Journal of Graphics
// Tools 7(2), 2002). A medium's number is that of its material.

// Sets have room for eight numbers, two in a word; 0: none, as the first material is never a medium's.
const uint kHalf = 0xffffu;

bool mediaLost;  // a ray was in more media, or met more interfaces in one place, than there is room for

// Bit i: place i of a set is free.
uint freeSlots(const uvec4 set) {
  uvec4 bits = uvec4(equal(set & kHalf, uvec4(0u))) * uvec4(1u, 2u, 4u, 8u) +
               uvec4(equal(set >> 16u, uvec4(0u))) * uvec4(16u, 32u, 64u, 128u);
  return bits.x + bits.y + bits.z + bits.w;
}

// A set with this number at this place, and nothing else.
uvec4 atSlot(const uint slot, const uint id) {
  uint moved = id << (slot >= 4u ? 16u : 0u);
  return mix(uvec4(0u), uvec4(moved), equal(uvec4(0u, 1u, 2u, 3u), uvec4(slot & 3u)));
}

uint idAt(const uvec4 set, const uint slot) {
  uint i = slot & 3u, word = i < 2u ? (i == 0u ? set.x : set.y) : (i == 2u ? set.z : set.w);
  return slot >= 4u ? word >> 16u : word & kHalf;
}

uvec4 without(const uvec4 set, const uint id) {
  uvec4 low = set & kHalf, high = set >> 16u;
  return mix(low, uvec4(0u), equal(low, uvec4(id))) | (mix(high, uvec4(0u), equal(high, uvec4(id))) << 16u);
}

bool has(const uvec4 set, const uint id) {
  return any(equal(set & kHalf, uvec4(id))) || any(equal(set >> 16u, uvec4(id)));
}

// In the first free place; a set that is full stays as it is.
uvec4 with(const uvec4 set, const uint id, out bool full) {
  uvec4 others = without(set, id);
  uint free = freeSlots(others);
  full = free == 0u;
  return full ? set : others | atSlot(uint(findLSB(free)), id);
}

// --- interfaces ---
// An interface is a medium and the side of it that a ray meets. All interfaces that it meets in one place make a set.
const uint kMaxInterfaces = 8u;
const uint kInterfaceFront = 0x8000u;  // the ray enters the medium

// The interface of a material, or 0 where that is no medium's.
uint interfaceOf(const uint material, const bool front) {
  return glassAt(material) == 0u ? 0u : material | (front ? kInterfaceFront : 0u);
}

uvec4 withInterface(const uvec4 interfaces, const uint interfaceId) {
  bool full;
  uvec4 more = with(interfaces, interfaceId, full);
  mediaLost = mediaLost || (full && interfaceId != 0u);
  return interfaceId == 0u ? interfaces : more;
}

// --- media ---
// The medium that is seen where a ray is in these, or 0 for air.
uint activeMedium(const uvec4 media) {
  uvec4 most = max(media & kHalf, media >> 16u);
  return max(max(most.x, most.y), max(most.z, most.w));
}

uvec4 withMedium(const uvec4 media, const uint medium) {
  bool full;
  uvec4 more = with(media, medium, full);
  mediaLost = mediaLost || full;
  return more;
}

// --- crossing ---
// A ray's way through all interfaces in one place.
struct Crossing {
  uvec4 beyond;  // the media that it is in behind them
  bool hidden;   // there is the same glass on both sides: no interface is to be seen
  vec2 etaRatio;  // index of refraction behind over that before, the sum of two floats
};

// The first turn of a loop is made in any case: an id of 0 is passed over.
bool isInterfaceAt(const uvec4 interfaces, const uint i) {
  return i == 0u || (i < kMaxInterfaces && idAt(interfaces, i) != 0u);
}

// The ray is in `media` and meets `interfaces` on a surface of this material. The sets are what is true: to enter a medium once
// more, or to leave it again, changes nothing. Nothing goes on through an opaque surface.
Crossing crossInterfaces(const uvec4 media, const uvec4 allInterfaces, const Material material, const bool front) {
  uvec4 interfaces = material.transmittance > 0.0 ? allInterfaces : uvec4(0u), beyond = media;
  uint i = 0u;
  do {
    if (LOOPS_AT_HEAD && !isInterfaceAt(interfaces, i)) break;
    uint interfaceId = idAt(interfaces, i);
    if (interfaceId != 0u && (interfaceId & kInterfaceFront) == 0u) beyond = without(beyond, interfaceId);
    ++i;
  } while (LOOPS_AT_HEAD || isInterfaceAt(interfaces, i));
  i = 0u;
  do {
    if (LOOPS_AT_HEAD && !isInterfaceAt(interfaces, i)) break;
    uint interfaceId = idAt(interfaces, i), medium = interfaceId & ~kInterfaceFront;
    // At a thin edge a ray may meet both sides of a medium at once: in the end it is out.
    if ((interfaceId & kInterfaceFront) != 0u && !has(interfaces, medium)) beyond = withMedium(beyond, medium);
    ++i;
  } while (LOOPS_AT_HEAD || isInterfaceAt(interfaces, i));

  Medium before = mediumAt(activeMedium(media)), behind = mediumAt(activeMedium(beyond));
  bool isMedium = material.glass != 0u;
  // What is no medium that matters: glass on its back, on its front whatever is there.
  if (!isMedium) {
    before.eta = front ? before.eta : material.eta;
    behind.eta = front ? material.eta : behind.eta;
  }
  vec2 etaRatio = wideProduct(vec2(behind.eta, 0), wideReciprocal(before.eta));
  return Crossing(beyond, isMedium && before.glass == behind.glass, etaRatio);
}
