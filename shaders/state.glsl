// What an invocation keeps between two dispatches, and its stack of rays that wait, which lives in the same buffer: a
// push or a pop is rare beside a traversal through the tree. Rows are listed in layout.h.

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
uvec4 hitInterfaces;     // the interfaces of media there
uvec4 media;       // that the ray is in (nested_dielectrics.glsl)
uint hiddenInterfaces;   // that it has passed since its last hit
uint light;         // the light that the hit's shadow ray goes to
TraversalState traversal;          // of the ray in hand, or of a shadow ray of its hit

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
  hitInterfaces = media = uvec4(0u);
  hiddenInterfaces = 0u;
  light = 0u;
  traversal = TraversalState(kRefNone, 0u, 0.0, kRefNone, 0u, uvec3(0u), 0.0, 0.0, 0.0, uvec4(0u));
  raysSpawned = nodesVisited = primitivesVisited = Row(0u);
}

void takeUpWork(const uint slot) {
  Row row = state[stateRow(kStateSum, slot)];
  sum = xyz(row);
  rayKind = row.w & 255u;
  level = (row.w >> 8u) & 255u;
  traversal.top = row.w >> 16u;
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
  traversal.list.z = row.w;
  row = state[stateRow(kStateTraversal, slot)];
  traversal.next = row.x;
  traversal.tMax = uintBitsToFloat(row.y);
  traversal.hit = row.z;
  traversal.rank = row.w;
  row = state[stateRow(kStateList, slot)];
  traversal.list.xy = row.xy;
  pending = row.zw;
  media = NESTED_DIELECTRICS ? state[stateRow(kStateMedia, slot)] : uvec4(0u);
  traversal.coincident = NESTED_DIELECTRICS ? state[stateRow(kStateCoincident, slot)] : uvec4(0u);
  hitInterfaces = NESTED_DIELECTRICS ? state[stateRow(kStateHitInterfaces, slot)] : uvec4(0u);
  row = NESTED_DIELECTRICS ? state[stateRow(kStateInterfaces, slot)] : Row(0u);
  traversal.nearestT = uintBitsToFloat(row.x);
  traversal.coincidence = uintBitsToFloat(row.y);
  hiddenInterfaces = row.z;
  traversal.hitT = uintBitsToFloat(row.w);
  raysSpawned = COUNTERS ? state[stateRow(kStateRays, slot)] : Row(0u);
  nodesVisited = COUNTERS ? state[stateRow(kStateNodes, slot)] : Row(0u);
  primitivesVisited = COUNTERS ? state[stateRow(kStatePrimitives, slot)] : Row(0u);
}

void putWorkAway(const uint slot) {
  state[stateRow(kStateSum, slot)] = packRow(sum, rayKind | (level << 8u) | (traversal.top << 16u));
  state[stateRow(kStateCompensation, slot)] = packRow(compensation, sampleIndex);
  state[stateRow(kStateRay, slot)] = packRow(ray.origin, ray.originPrimitive);
  state[stateRow(kStateDirection, slot)] = packRow(ray.direction, floatBitsToUint(weight));
  state[stateRow(kStateHit, slot)] = Row(floatBitsToUint(hitT), hitPrimitive, light, traversal.list.z);
  state[stateRow(kStateTraversal, slot)] = Row(traversal.next, floatBitsToUint(traversal.tMax), traversal.hit, traversal.rank);
  state[stateRow(kStateList, slot)] = Row(traversal.list.xy, pending);
  if (NESTED_DIELECTRICS) {
    state[stateRow(kStateMedia, slot)] = media;
    state[stateRow(kStateCoincident, slot)] = traversal.coincident;
    state[stateRow(kStateHitInterfaces, slot)] = hitInterfaces;
    state[stateRow(kStateInterfaces, slot)] = Row(floatBitsToUint(traversal.nearestT), floatBitsToUint(traversal.coincidence), hiddenInterfaces, floatBitsToUint(traversal.hitT));
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

const uint kRayRows = NESTED_DIELECTRICS ? 3u : 2u;

// A ray of the next level waits.
void pushRay(const uint slot, const Ray waiting, const float itsWeight, const uvec4 itsMedia) {
  uint row = kStateRayStack + kRayRows * (level - 1u);
  state[stateRow(row, slot)] = packRow(waiting.origin, waiting.originPrimitive);
  state[stateRow(row + 1u, slot)] = packRow(waiting.direction, floatBitsToUint(itsWeight));
  if (NESTED_DIELECTRICS) state[stateRow(row + 2u, slot)] = itsMedia;
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
  if (NESTED_DIELECTRICS) media = state[stateRow(row + 2u, slot)];
  hiddenInterfaces = 0u;
  rayKind = kRefracted;  // a reflected ray is never the one that waits
}

// --- the node stack of an interrupted traversal ---
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
