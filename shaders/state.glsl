// What an invocation keeps between two dispatches, and its stack of rays that wait, which lives in the same buffer: a
// push or a pop is rare beside a walk through the tree. Rows are listed in layout.h.

Row packRow(vec3 v, uint w) { return Row(floatBitsToUint(v), w); }

// Index of a row of this invocation's state: neighbours lie side by side.
uint stateRow(uint row, uint slot) { return row * tile.slots + slot; }

// --- the ray stack: at most one ray waits on each level, so that its place tells its level ---
bool anyPending(uvec2 pending) { return (pending.x | pending.y) != 0u; }

uint deepestPending(uvec2 pending) { return pending.y != 0u ? 32u + uint(findMSB(pending.y)) : uint(findMSB(pending.x)); }

// The bit of a level (1 to 64) in the mask of levels that have a ray waiting.
uvec2 levelBit(uint level) {
  uint bit = level - 1u;
  return bit < 32u ? uvec2(1u << bit, 0u) : uvec2(0u, 1u << (bit - 32u));
}

void pushRay(uint slot, uint level, Ray ray, float weight) {
  uint row = kStateRayStack + 2u * (level - 2u);
  state[stateRow(row, slot)] = packRow(ray.origin, ray.leaving);
  state[stateRow(row + 1u, slot)] = packRow(ray.direction, floatBitsToUint(weight));
}

void popRay(uint slot, uint level, out Ray ray, out float weight) {
  uint row = kStateRayStack + 2u * (level - 2u);
  Row origin = state[stateRow(row, slot)], direction = state[stateRow(row + 1u, slot)];
  ray = Ray(xyz(origin), xyz(direction), origin.w);
  weight = uintBitsToFloat(direction.w);
}

// --- the node stack of an interrupted walk ---
void saveNodeStack(uint slot, uint top) {
  for (uint i = 0u; i < top; i += 4u)
    state[stateRow(kStateNodeStack + i / 4u, slot)] =
        Row(nodeStack[i], nodeStack[i + 1u], nodeStack[i + 2u], nodeStack[i + 3u]);
}

void loadNodeStack(uint slot, uint top) {
  for (uint i = 0u; i < top; i += 4u) {
    Row row = state[stateRow(kStateNodeStack + i / 4u, slot)];
    nodeStack[i] = row.x;
    nodeStack[i + 1u] = row.y;
    nodeStack[i + 2u] = row.z;
    nodeStack[i + 3u] = row.w;
  }
}
