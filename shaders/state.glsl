// What an invocation keeps between two dispatches, and its stack of rays that wait, which lives in the same buffer: a
// push or a pop is rare beside a walk through the tree. Rows are listed in layout.h.

// --- the work in hand ---
uint phase;         // where the invocation stands: a constant of whitted.comp
uint sampleIndex;   // the sample of the pixel that is being traced
vec3 sum;           // of the radiance of all samples so far
vec3 compensation;  // what sum has lost to rounding
Ray ray;            // the eye or secondary ray in hand
uint rayKind;       // kEye, kReflected or kRefracted
float weight;       // product of the r and t factors on its way
uint level;         // of it in the ray tree; the eye ray has 1
uvec2 pending;      // bit l - 1: a ray waits on level l
float hitT;         // where it hits
uint hitPrimitive;  // and what
uvec4 hitPlace;     // the walls of solids there
uvec4 solids;       // that the ray is in (solids.glsl)
uint hiddenWalls;   // that it has passed since its last hit
uint light;         // the light that the hit's shadow ray goes to
Walk walk;          // of the ray in hand, or of a shadow ray of its hit

Row packRow(const vec3 v, const uint w) { return Row(floatBitsToUint(v), w); }

// Index of a row of this invocation's state: neighbours lie side by side.
uint stateRow(const uint row, const uint slot) { return row * tile.slots + slot; }

// A pixel not yet begun.
void beginWork() {
  sampleIndex = 0u;
  sum = vec3(0);
  compensation = vec3(0);
  ray = Ray(vec3(0), vec3(0, 0, 1), kRefNone);
  rayKind = 0u;
  weight = 0.0;
  level = 0u;
  pending = uvec2(0u);
  hitT = 0.0;
  hitPrimitive = kRefNone;
  hitPlace = solids = uvec4(0u);
  hiddenWalls = 0u;
  light = 0u;
  walk = Walk(kRefNone, 0u, 0.0, kRefNone, 0u, uvec3(0u), 0.0, 0.0, 0.0, uvec4(0u));
  raysSpawned = nodesVisited = primitivesVisited = Row(0u);
}

void takeUpWork(const uint slot) {
  Row row = state[stateRow(kStateSum, slot)];
  sum = xyz(row);
  rayKind = row.w & 255u;
  level = (row.w >> 8u) & 255u;
  walk.top = row.w >> 16u;
  row = state[stateRow(kStateCompensation, slot)];
  compensation = xyz(row);
  sampleIndex = row.w;
  row = state[stateRow(kStateRay, slot)];
  Row direction = state[stateRow(kStateDirection, slot)];
  ray = Ray(xyz(row), xyz(direction), row.w);
  weight = uintBitsToFloat(direction.w);
  row = state[stateRow(kStateHit, slot)];
  hitT = uintBitsToFloat(row.x);
  hitPrimitive = row.y;
  light = row.z;
  walk.list.z = row.w;
  row = state[stateRow(kStateWalk, slot)];
  walk.next = row.x;
  walk.tMax = uintBitsToFloat(row.y);
  walk.hit = row.z;
  walk.order = row.w;
  row = state[stateRow(kStateList, slot)];
  walk.list.xy = row.xy;
  pending = row.zw;
  solids = SOLIDS ? state[stateRow(kStateSolids, slot)] : uvec4(0u);
  walk.place = SOLIDS ? state[stateRow(kStatePlace, slot)] : uvec4(0u);
  hitPlace = SOLIDS ? state[stateRow(kStateHitPlace, slot)] : uvec4(0u);
  row = SOLIDS ? state[stateRow(kStateWalls, slot)] : Row(0u);
  walk.first = uintBitsToFloat(row.x);
  walk.apart = uintBitsToFloat(row.y);
  hiddenWalls = row.z;
  walk.hitT = uintBitsToFloat(row.w);
  raysSpawned = COUNTERS ? state[stateRow(kStateRays, slot)] : Row(0u);
  nodesVisited = COUNTERS ? state[stateRow(kStateNodes, slot)] : Row(0u);
  primitivesVisited = COUNTERS ? state[stateRow(kStatePrimitives, slot)] : Row(0u);
}

void putWorkAway(const uint slot) {
  state[stateRow(kStateSum, slot)] = packRow(sum, rayKind | (level << 8u) | (walk.top << 16u));
  state[stateRow(kStateCompensation, slot)] = packRow(compensation, sampleIndex);
  state[stateRow(kStateRay, slot)] = packRow(ray.origin, ray.leaving);
  state[stateRow(kStateDirection, slot)] = packRow(ray.direction, floatBitsToUint(weight));
  state[stateRow(kStateHit, slot)] = Row(floatBitsToUint(hitT), hitPrimitive, light, walk.list.z);
  state[stateRow(kStateWalk, slot)] = Row(walk.next, floatBitsToUint(walk.tMax), walk.hit, walk.order);
  state[stateRow(kStateList, slot)] = Row(walk.list.xy, pending);
  if (SOLIDS) {
    state[stateRow(kStateSolids, slot)] = solids;
    state[stateRow(kStatePlace, slot)] = walk.place;
    state[stateRow(kStateHitPlace, slot)] = hitPlace;
    state[stateRow(kStateWalls, slot)] = Row(floatBitsToUint(walk.first), floatBitsToUint(walk.apart), hiddenWalls, floatBitsToUint(walk.hitT));
  }
}

void putCountsAway(const uint slot) {
  state[stateRow(kStateRays, slot)] = raysSpawned;
  state[stateRow(kStateNodes, slot)] = nodesVisited;
  state[stateRow(kStatePrimitives, slot)] = primitivesVisited;
}

// --- the ray stack: at most one ray waits on each level, so that its place tells its level ---
bool anyPending() { return (pending.x | pending.y) != 0u; }

uint deepestPending() { return 1u + (pending.y != 0u ? 32u + uint(findMSB(pending.y)) : uint(findMSB(pending.x))); }

// The bit of a level (1 to 64) in the mask of levels that have a ray waiting.
uvec2 levelBit(const uint level) {
  uint bit = level - 1u;
  return bit < 32u ? uvec2(1u << bit, 0u) : uvec2(0u, 1u << (bit - 32u));
}

const uint kRayRows = SOLIDS ? 3u : 2u;

// A ray of the next level waits.
void pushRay(const uint slot, const Ray waiting, const float itsWeight, const uvec4 itsSolids) {
  uint row = kStateRayStack + kRayRows * (level - 1u);
  state[stateRow(row, slot)] = packRow(waiting.origin, waiting.leaving);
  state[stateRow(row + 1u, slot)] = packRow(waiting.direction, floatBitsToUint(itsWeight));
  if (SOLIDS) state[stateRow(row + 2u, slot)] = itsSolids;
  pending |= levelBit(level + 1u);
}

// The deepest ray that waits becomes the ray in hand.
void popRay(const uint slot) {
  level = deepestPending();
  pending &= ~levelBit(level);
  uint row = kStateRayStack + kRayRows * (level - 2u);
  Row origin = state[stateRow(row, slot)], direction = state[stateRow(row + 1u, slot)];
  ray = Ray(xyz(origin), xyz(direction), origin.w);
  weight = uintBitsToFloat(direction.w);
  if (SOLIDS) solids = state[stateRow(row + 2u, slot)];
  hiddenWalls = 0u;
  rayKind = kRefracted;  // a reflected ray is never the one that waits
}

// --- the node stack of an interrupted walk ---
void saveNodeStack(const uint slot, const uint top) {
  for (uint i = 0u; i < top; i += 4u)
    state[stateRow(kStateNodeStack + i / 4u, slot)] =
        Row(nodeStack[i], nodeStack[i + 1u], nodeStack[i + 2u], nodeStack[i + 3u]);
}

void loadNodeStack(const uint slot, const uint top) {
  for (uint i = 0u; i < top; i += 4u) {
    Row row = state[stateRow(kStateNodeStack + i / 4u, slot)];
    nodeStack[i] = row.x;
    nodeStack[i + 1u] = row.y;
    nodeStack[i + 2u] = row.z;
    nodeStack[i + 3u] = row.w;
  }
}
