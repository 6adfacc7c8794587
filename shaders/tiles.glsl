// The place of an invocation's pixel in the tile that one dispatch works on.

uint slot;     // index of the invocation in the tile, and of its state
uvec2 pixel;   // in the full picture
uint pixelAt;  // index in the buffer of the tile's pixels
bool hasSlot;  // a dispatch may have more invocations than the tile has slots
bool isMine;   // some slots have no pixel: the tile's last blocks reach beyond it

// The even bits of an index: half of a Morton code.
uint evenBits(uint i) {
  i &= 0x55555555u;
  i = (i | (i >> 1u)) & 0x33333333u;
  i = (i | (i >> 2u)) & 0x0f0f0f0fu;
  i = (i | (i >> 4u)) & 0x00ff00ffu;
  return (i | (i >> 8u)) & 0x0000ffffu;
}

// a / b for a < 2^22, by way of float: lavapipe divides integers lane by lane.
uint quotient(const uint a, const uint b) { return uint(int((float(int(a)) + 0.5) / float(int(b)))); }

// The slot of this invocation. A CPU device gives each of its threads one contiguous share of the work-groups; dealing
// the groups out in turn gives every thread a part of the sky and a part of the ground.
uint invocationSlot() {
  uint group = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
  if (group >= tile.groups) return tile.slots;  // the grid's last row may be longer than the work
  uint threads = frame.threads;
  uint share = quotient(tile.groups, threads), turn = quotient(group, max(share, 1u));
  uint dealt = group < share * threads ? (group - turn * share) * threads + turn : group;
  return (tile.firstGroup + dealt) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}

// The pixel of a slot, within the tile: blocks of 8x8 row by row, Morton order inside, so that the lanes of a SIMD unit
// see a compact piece of the picture.
uvec2 slotPixel(const uint slot) {
  uint blocksInRow = (tile.width + 7u) / 8u;
  uint block = slot / 64u, inside = slot % 64u;
  uint y = quotient(block, blocksInRow), x = block - y * blocksInRow;
  return uvec2(8u * x + evenBits(inside), 8u * y + evenBits(inside >> 1u));
}

void findPixel() {
  slot = invocationSlot();
  uvec2 inTile = slotPixel(slot);
  hasSlot = slot < tile.slots;
  isMine = hasSlot && inTile.x < tile.width && inTile.y < tile.height;
  slot = min(slot, tile.slots - 1u);
  pixel = uvec2(tile.x0, tile.y0) + tile.stride * inTile;
  pixelAt = inTile.y * tile.width + inTile.x;
}
