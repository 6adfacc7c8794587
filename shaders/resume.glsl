// What an invocation keeps between two dispatches: its path state, the work in hand, its stack of waiting rays, which
// lives in the same buffer, as a push or a pop is rare beside a traversal. No dispatch runs long (docs/kernel.md): when
// the budget of iterations is spent the invocation suspends its work, and the next dispatch resumes it.

// --- path states ---
const uint kNextSample = 0u;    // no ray in hand and none waiting; zero, so that cleared state is a fresh pixel
const uint kTrace = 1u;         // the ray in hand looks for its nearest hit
const uint kNextLight = 2u;     // the hit is known; next is a light
const uint kTraceShadow = 3u;   // a shadow ray of the hit is on its way to that light
const uint kNextRay = 4u;       // the ray in hand is done with
const uint kDone = kPixelDone;  // the pixel is finished

// --- the work in hand ---
uint phase;             // the path state
uint sampleIndex;       // the sample of the pixel that is being traced
vec3 sum;               // of the radiance of all samples so far
vec3 compensation;      // what sum has lost to rounding
Ray currentRay;                // the eye or secondary ray in hand
uint rayKind;           // kEye, kReflected or kRefracted
float weight;           // product of the r and t factors on its way
uint level;             // of it in the ray tree; the eye ray has 1
uvec2 pending;          // bit l - 1: a ray waits on level l
float hitT;             // where it hits
uint hitPrimitive;      // and what
uvec4 hitInterfaces;    // the interfaces of media there
uvec4 media;            // that the ray is in (nested_dielectrics.glsl)
uint hiddenInterfaces;  // that it has passed since its last hit
uint lightIndex;        // the light that the hit's shadow ray goes to
TraversalState traversal;  // of the ray in hand, or of a shadow ray of its hit

// --- the buffer of states ---
// Index of a word of this invocation's state: neighbours lie side by side.
uint stateAt(const uint word) { return word * tile.slots + slot; }

uint toWord(const bool value) { return uint(value); }
uint toWord(const int value) { return uint(value); }
uint toWord(const uint value) { return value; }
uint toWord(const float value) { return floatBitsToUint(value); }
void fromWord(const uint word, out bool value) { value = word != 0u; }
void fromWord(const uint word, out int value) { value = int(word); }
void fromWord(const uint word, out uint value) { value = word; }
void fromWord(const uint word, out float value) { value = uintBitsToFloat(word); }

uint packedLevel;  // rayKind | level << 8 | top of the node stack << 16

// All that is kept, in words of four: KEEP(index of the word, four values). Below kStateRays.
#define TURNER_STATE(KEEP)                                                                                     \
  KEEP(0u, sum.x, sum.y, sum.z, packedLevel)                                                                   \
  KEEP(1u, compensation.x, compensation.y, compensation.z, sampleIndex)                                        \
  KEEP(2u, currentRay.origin.x, currentRay.origin.y, currentRay.origin.z, currentRay.originPrimitive)                                      \
  KEEP(3u, currentRay.direction.x, currentRay.direction.y, currentRay.direction.z, weight)                                          \
  KEEP(4u, hitT, hitPrimitive, lightIndex, traversal.list.firstPair)                                           \
  KEEP(5u, traversal.next, traversal.tMax, traversal.hit, traversal.rank)                                      \
  KEEP(6u, traversal.list.first, traversal.list.end, pending.x, pending.y)
// Where there are nested dielectrics; behind the node stack.
#define TURNER_STATE_OF_MEDIA(KEEP)                                                                            \
  KEEP(22u, media.x, media.y, media.z, media.w)                                                                \
  KEEP(23u, traversal.coincident.x, traversal.coincident.y, traversal.coincident.z, traversal.coincident.w)    \
  KEEP(24u, hitInterfaces.x, hitInterfaces.y, hitInterfaces.z, hitInterfaces.w)                                \
  KEEP(25u, traversal.nearestT, traversal.coincidence, hiddenInterfaces, traversal.hitT)
#define TURNER_SAVE(word, a, b, c, d) state[stateAt(word)] = Word4(toWord(a), toWord(b), toWord(c), toWord(d));
#define TURNER_LOAD(word, a, b, c, d) \
  kept = state[stateAt(word)];        \
  fromWord(kept.x, a);                \
  fromWord(kept.y, b);                \
  fromWord(kept.z, c);                \
  fromWord(kept.w, d);

// Of an edit's global variables, which the host lists in EDIT_STATE; in main(), where all of them are declared.
#ifdef EDITED
uint editPadding;
uint editWord(const uint i) { return kStateRayStack + (NESTED_DIELECTRICS ? 3u : 2u) * (DEPTH - 1u) + i; }
#define SUSPEND_EDIT() EDIT_STATE(TURNER_SAVE)
#define RESUME_EDIT() \
  Word4 kept;         \
  EDIT_STATE(TURNER_LOAD)
#else
#define SUSPEND_EDIT()
#define RESUME_EDIT()
#endif

void loadNodeStack() {
  for (uint i = 0u; i < traversal.top; i += 4u) {
    Word4 kept = state[stateAt(kStateNodeStack + i / 4u)];
    nodeStack[i] = kept.x;
    nodeStack[i + 1u] = kept.y;
    nodeStack[i + 2u] = kept.z;
    nodeStack[i + 3u] = kept.w;
  }
}

void saveNodeStack() {
  for (uint i = 0u; i < traversal.top; i += 4u)
    state[stateAt(kStateNodeStack + i / 4u)] =
        Word4(nodeStack[i], nodeStack[i + 1u], nodeStack[i + 2u], nodeStack[i + 3u]);
}

// A pixel not yet begun.
void beginWork() {
  sampleIndex = 0u;
  sum = vec3(0);
  compensation = vec3(0);
  currentRay = Ray(vec3(0), vec3(0, 0, 1), kRefNone);
  rayKind = 0u;
  weight = 0.0;
  level = 0u;
  pending = uvec2(0u);
  hitT = 0.0;
  hitPrimitive = kRefNone;
  hitInterfaces = media = uvec4(0u);
  hiddenInterfaces = 0u;
  lightIndex = 0u;
  traversal = startAt(kRefNone, 0.0, kNoList);
  raysSpawned = nodesVisited = primitivesVisited = Word4(0u);
}

// Begins a sample with its eye ray.
void beginSample() {
  currentRay = Ray(vec3(0), eyeDirection(pixel, sampleIndex), kRefNone);
  rayKind = kEye;
  weight = 1.0;
  level = 1u;
  if (NESTED_DIELECTRICS) media = frame.media, hiddenInterfaces = 0u;
  traversal = startEyeRay(currentRay, rayFactors(currentRay.direction));
  phase = kTrace;
  if (COUNTERS) ++raysSpawned[kEye];
}

// Resumes the work where the last dispatch left it.
void resumeWork() {
  beginWork();
  Word4 kept;
  TURNER_STATE(TURNER_LOAD)
  if (NESTED_DIELECTRICS) {
    TURNER_STATE_OF_MEDIA(TURNER_LOAD)
  }
  if (CONES) traversal.list.firstCone = state[stateAt(kStateFirstCone)].x;
  rayKind = packedLevel & 255u;
  level = (packedLevel >> 8u) & 255u;
  traversal.top = packedLevel >> 16u;
  if (COUNTERS) {
    raysSpawned = state[stateAt(kStateRays)];
    nodesVisited = state[stateAt(kStateNodes)];
    primitivesVisited = state[stateAt(kStatePrimitives)];
  }
  phase = isMine ? pixels[pixelAt].w : kDone;
  if (phase == kDone) traversal.next = kRefNone, traversal.top = 0u;
  if (NEAREST_NODES || SHADOW_NODES) loadNodeStack();
}

void saveCounts() {
  state[stateAt(kStateRays)] = raysSpawned;
  state[stateAt(kStateNodes)] = nodesVisited;
  state[stateAt(kStatePrimitives)] = primitivesVisited;
}

#ifdef EDITED
// Whether a dispatch has left the work as it was: it will never come further, as where an edit returns before it moves on.
#define TURNER_COMPARE(word, a, b, c, d) \
  same = same && state[stateAt(word)] == Word4(toWord(a), toWord(b), toWord(c), toWord(d));
bool isAsKept() {
  Word4 before = pixels[pixelAt];
  bool same = !FRESH && before.w == phase;
  packedLevel = rayKind | (level << 8u) | (traversal.top << 16u);
  TURNER_STATE(TURNER_COMPARE)
  if (NESTED_DIELECTRICS) {
    TURNER_STATE_OF_MEDIA(TURNER_COMPARE)
  }
  return same;
}
#endif

// Suspends work that is not done; tells the host.
void suspendWork() {
  packedLevel = rayKind | (level << 8u) | (traversal.top << 16u);
  TURNER_STATE(TURNER_SAVE)
  if (NESTED_DIELECTRICS) {
    TURNER_STATE_OF_MEDIA(TURNER_SAVE)
  }
  if (CONES) state[stateAt(kStateFirstCone)] = Word4(traversal.list.firstCone, 0u, 0u, 0u);
  if (NEAREST_NODES || SHADOW_NODES) saveNodeStack();
  atomicAdd(status.unfinished, 1u);
  atomicAdd(status.samplesWaiting, SAMPLES * SAMPLES - sampleIndex);
}

// --- the ray stack: at most one ray waits on each level, so that its place tells its level ---
bool anyPending() { return (pending.x | pending.y) != 0u; }

uint deepestPending() { return 1u + (pending.y != 0u ? 32u + uint(findMSB(pending.y)) : uint(findMSB(pending.x))); }

// The bit of a level (1 to 64) in the mask of levels that have a ray waiting.
uvec2 levelBit(const uint level) {
  uint bit = level - 1u;
  return bit < 32u ? uvec2(1u << bit, 0u) : uvec2(0u, 1u << (bit - 32u));
}

const uint kRayWords = NESTED_DIELECTRICS ? 3u : 2u;

// A ray of the next level waits.
void pushRay(const Ray waiting, const float itsWeight, const uvec4 itsMedia) {
  LACKS(Refraction, !REFRACTION);
#ifdef EDITED
  // The state has no row for it.
  LACKS(Depth, level >= DEPTH);
  if (level >= DEPTH) return;
#endif
  uint word = kStateRayStack + kRayWords * (level - 1u);
  state[stateAt(word)] = packWord(waiting.origin, waiting.originPrimitive);
  state[stateAt(word + 1u)] = packWord(waiting.direction, floatBitsToUint(itsWeight));
  if (NESTED_DIELECTRICS) state[stateAt(word + 2u)] = itsMedia;
  pending |= levelBit(level + 1u);
}

// The deepest ray that waits becomes the ray in hand.
void popRay() {
  level = deepestPending();
  pending &= ~levelBit(level);
  uint word = kStateRayStack + kRayWords * (level - 2u);
  Word4 origin = state[stateAt(word)], direction = state[stateAt(word + 1u)];
  currentRay = Ray(xyz(origin), xyz(direction), origin.w);
  weight = uintBitsToFloat(direction.w);
  if (NESTED_DIELECTRICS) media = state[stateAt(word + 2u)];
  hiddenInterfaces = 0u;
  rayKind = kRefracted;  // a reflected ray is never the one that waits
}
