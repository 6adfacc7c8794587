// Traversal of a ray: along the cell list of its direction, and from there through the tree of boxes. In: a ray and the
// state of its traversal. Out: the same, farther on; the nearest primitive, or for a shadow ray any.

struct TraversalState {
  uint next;      // reference to visit next; kRefNone: the traversal is finished
  uint top;       // entries on the node stack
  float tMax;     // distance of the best hit so far; before the first, how far the ray reaches
  uint hit;       // the best primitive so far (type and offset), or kRefNone
  uint rank;      // its tie-break rank
  FineCell list;  // the rest of the cell list
  // Nested dielectrics: a second pass collects all interfaces that coincide with the nearest hit.
  float nearestT;     // t of that hit
  float coincidence;  // how far behind it an interface still coincides; 0 in the first pass, where hitT is tMax
  // Second pass: t of the best coinciding hit, that of the lowest rank. First pass: how far interfaces may coincide
  // with the nearest hit, 0 if that is no interface of a medium.
  float hitT;
  uvec4 coincident;  // the coinciding interfaces (nested_dielectrics.glsl)
};

// References still to be visited. A path through the tree leaves at most one on each level.
uint nodeStack[kMaxTreeDepth];

const FineCell kNoList = FineCell(0u, 0u, 0u, 0u);

TraversalState startAt(const uint next, const float tMax, const FineCell list) {
  return TraversalState(next, 0u, tMax, kRefNone, 0u, list, 0.0, 0.0, 0.0, uvec4(0u));
}

// How far a shadow ray reaches. Its end is open: what stands exactly at the light does not block it.
const float kToLight = 1.0 - 1.0 / 1048576.0;

#ifndef EDITED
// A ray from anywhere traverses the whole tree.
TraversalState startAtRoot() { return startAt(frame.root, kNoHit, kNoList); }

// A ray through the eye or a light begins with the cell list of its direction.
TraversalState startInCellList(const FineCell list, const float tMax) { return startAt(kRefNext, tMax, list); }

// An eye ray; what it says of its start is true.
TraversalState startEyeRay(const Ray ray, const RayFactors factors) {
  return startInCellList(cellList(kEyeBuffer, directionFace(ray.direction, factors.axis), factors.shear.xy), kNoHit);
}

// A ray that ends at a light. Seen from there it comes through the opposite face.
TraversalState startShadowRay(const Ray ray, const RayFactors factors, const uint light) {
  uint face = directionFace(-ray.direction, factors.axis);
  return startInCellList(cellList(kEyeBuffer + 1u + light, face, factors.shear.xy), kToLight);
}
#else
// Whoever edits may move or turn a ray until its traversal begins: only then is it known whether a list is made for it. Until
// then the state says which light buffer might have one.
const uint kRefBegin = 0xfffffffdu;  // as traversal.next: begin with checkedStart()
const uint kNoBuffer = kRefNone;

TraversalState startLater(const uint lightBuffer, const float tMax) {
  return startAt(kRefBegin, tMax, FineCell(lightBuffer, 0u, 0u, 0u));
}
TraversalState startAtRoot() { return startLater(kNoBuffer, kNoHit); }
TraversalState startInCellList(const FineCell list, const float tMax) { return startLater(kNoBuffer, tMax); }
TraversalState startEyeRay(const Ray ray, const RayFactors factors) { return startLater(kEyeBuffer, kNoHit); }
TraversalState startShadowRay(const Ray ray, const RayFactors factors, const uint light) {
  return startLater(kEyeBuffer + 1u + light, kToLight);
}

// The beginning of a traversal: the list of its light buffer, if the ray is one of those that the list is made for, else the
// tree. Lists of lights are sorted from the light on, so that they are for rays that look for any hit.
TraversalState checkedStart(const Ray ray, const RayFactors factors, const bool anyHit, const bool visitsNodes,
                            const TraversalState asked) {
  uint lightBuffer = asked.list.first;
  bool isEyeRay = !anyHit && lightBuffer == kEyeBuffer && ray.origin == vec3(0) && isThroughPixel(ray.direction);
  bool isToLight = anyHit && asked.tMax <= 1.0 && lightBuffer - kEyeBuffer - 1u < LIGHTS &&
                   endsAt(ray, min(lightBuffer - kEyeBuffer - 1u, LIGHTS - 1u));
  FineCell list = cellList(isToLight ? lightBuffer : kEyeBuffer,
                           directionFace(isToLight ? -ray.direction : ray.direction, factors.axis), factors.shear.xy);
  bool needsTree = !isEyeRay && !isToLight;
  LACKS(NearestNodes, needsTree && !anyHit && !visitsNodes);
  LACKS(ShadowNodes, needsTree && anyHit && !visitsNodes);
  // Where the tree is compiled out, nothing: the picture will be traced anew.
  uint first = !needsTree ? kRefNext : visitsNodes ? frameInMemory.root : kRefNone;
  if (needsTree) list = kNoList;
  return startAt(first, asked.tMax, list);
}
#endif

// Whether the first pass has found a nearest hit on an interface, and the second is still to come.
bool lacksCoincident(const TraversalState traversal) {
  return NESTED_DIELECTRICS && traversal.coincidence == 0.0 && traversal.hit != kRefNone && traversal.hitT > 0.0;
}

// The second pass: through the tree once more, for all that coincides with the nearest hit.
TraversalState startCoincident(const TraversalState first) {
  TraversalState second = startAt(frame.root, first.tMax + first.hitT, kNoList);
  second.rank = kRefNone;
  second.nearestT = second.hitT = first.tMax;
  second.coincidence = first.hitT;
  return second;
}

bool isFinished(const TraversalState traversal) { return traversal.next == kRefNone; }

// The traversal's next reference from its stack, if there is one.
void popNode(inout TraversalState traversal) {
  traversal.next = kRefNext;
  if (traversal.top > 0u) {
    --traversal.top;
    traversal.next = nodeStack[traversal.top];
  }
}

// The next entry of the list. Entries are sorted: behind what is beyond the limit everything is.
void takeEntry(inout TraversalState traversal, const float limit) {
  ListEntry entry = listEntryAt(traversal.list.first);
#ifdef EDITED
  // A kernel whose scene needs no nodes for such rays may have got them: its lists are sorted type by type.
  uint nextType = traversal.list.first < traversal.list.firstPair ? traversal.list.firstPair : traversal.list.end;
  if (CONES && traversal.list.first < traversal.list.firstCone) nextType = traversal.list.firstCone;
  if (traversal.list.first < traversal.list.end && entry.distance > limit && nextType < traversal.list.end) {
    traversal.list.first = nextType;
    return;
  }
#endif
  traversal.next = traversal.list.first < traversal.list.end && entry.distance <= limit ? entry.reference : kRefNone;
  ++traversal.list.first;
}

// Where a ray enters one of a node's boxes, or kNoHit if it does not before tMax. `near` and `far` hold the planes that
// it meets first and last on each axis. The interval is widened by 2^-20: Vulkan allows a division 2.5 ulp of error, for
// which the usual 3 ulp do not suffice (Ize, JCGT 2(2), 2013).
float enterBox(const vec3 near, const vec3 far, const float tMax) {
  float enter = greater(greater(near.x, near.y), greater(near.z, 0.0)) * (1.0 - 1.0 / 1048576.0);
  float leave = lesser(lesser(far.x, far.y), lesser(far.z, tMax));
  return enter <= leave * (1.0 + 1.0 / 1048576.0) ? enter : kNoHit;
}

// Four planes are the bytes of an integer; this takes one of each axis.
vec3 planesAt(const uvec3 planes, const uvec3 shift) { return vec3(ivec3((planes >> shift) & 255u)); }

// Goes on with the nearer child that the ray enters; the other one waits on the stack. What waits there is taken up
// outside the loops: lavapipe reads a stack lane by lane, which takes a good part of a visit's time.
void visitNode(const Ray ray, const RayFactors factors, inout TraversalState traversal) {
  Node node = nodeAt(traversal.next);
  // t of a plane is (origin + byte * scale - ray.origin) / direction.
  vec3 scale = uintBitsToFloat((uvec3(node.exponents) << uvec3(23u, 15u, 7u)) & 0x7f800000u) * factors.inverse;
  vec3 start = (node.origin - ray.origin) * factors.inverse;
  float enter0 = enterBox(planesAt(node.planes, factors.nearShift) * scale + start,
                          planesAt(node.planes, 8u - factors.nearShift) * scale + start, traversal.tMax);
  float enter1 = enterBox(planesAt(node.planes, factors.nearShift + 16u) * scale + start,
                          planesAt(node.planes, 24u - factors.nearShift) * scale + start, traversal.tMax);

  // The references of both children, see Node in scene.h.
  uint below = traversal.next + 1u, tags = node.exponents >> 24u;
  uint firstCount = ((node.reference >> kRefCountShift) & kRefCountMask) + 1u;
  uint secondOffset = (node.reference & kRefOffsetMask) + firstCount * unitsOf(typeOf(node.reference));
  uint secondLeaf = kRefLeaf | ((tags << 26u) & 0x70000000u) | secondOffset;
  if (CONES) secondLeaf |= (tags << 22u) & kRefCone;
  uint child0 = (tags & 1u) != 0u ? node.reference : below;
  uint child1 = (tags & 1u) == 0u ? node.reference : (tags & 2u) == 0u ? below : secondLeaf;

  bool firstIsNearer = enter0 <= enter1;
  traversal.next = firstIsNearer ? child0 : child1;
  bool both = max(enter0, enter1) < kNoHit, neither = min(enter0, enter1) == kNoHit;
  if (both) {
    nodeStack[traversal.top] = firstIsNearer ? child1 : child0;
    ++traversal.top;
  }
  if (neither) traversal.next = kRefNext;
}

// Tests a primitive; true if it takes the traversal's hit. Among equal distances the lowest rank wins, so that the picture
// does not depend on the tree.
bool intersectPrimitive(const Ray ray, const RayFactors factors, const uint primitive, const uint type,
                        const bool anyHit, const uint kind, inout TraversalState traversal, out bool both) {
  Intersection found = intersect(ray, factors, primitive, type);
  bool taken = found.t < traversal.tMax;
  if (!anyHit) taken = taken || (found.t == traversal.tMax && traversal.hit != kRefNone && found.rank < traversal.rank);
  bool gathers = NESTED_DIELECTRICS && !anyHit && traversal.coincidence > 0.0;
  if (gathers) {
    // What is no interface of a medium is no more than roundings away from what it touches.
    float most = found.interfaceId != 0u ? traversal.coincidence : 0.25 * traversal.coincidence;
    bool coincides = found.t <= traversal.nearestT + most;
    if (coincides) traversal.coincident = withInterface(traversal.coincident, found.interfaceId);
    taken = coincides && found.rank < traversal.rank;
    if (taken) traversal.hitT = found.t;
  } else if (taken && !anyHit) {
    traversal.tMax = found.t;
    // Of the nearest hit so far: whether it is an interface, and how far its place will reach.
    if (NESTED_DIELECTRICS) traversal.hitT = found.interfaceId != 0u ? found.coincidence : 0.0;
  }
  if (taken) traversal.hit = found.primitive;
  if (taken && !anyHit) traversal.rank = found.rank;
  both = found.both;
  if (COUNTERS) primitivesVisited[kind] += found.tested;
  return taken;
}

// On to the leaf's next primitive, or to whatever follows the leaf.
void nextPrimitive(const uint type, const bool both, inout TraversalState traversal) {
  bool last = ((traversal.next >> kRefCountShift) & kRefCountMask) == 0u;
  uint whole = CONES && type == kCones ? traversal.next : traversal.next & ~kRefSecond;
  uint following = last ? kRefNext : whole + unitsOf(type) - (1u << kRefCountShift);
  traversal.next = both ? traversal.next | kRefSecond : following;
}

// Iterations that lavapipe 22.3 counts for loops no lane enters: it runs the body of every loop at least once. Callers of
// traverse subtract them from the budget, those too whose other lanes call it.
int idleTurns(const bool visitsNodes) { return visitsNodes ? 3 : int(SPHERES) + int(CONES) + int(TRIANGLES); }

bool isAtNode(const TraversalState traversal) { return (traversal.next & kRefLeaf) == 0u; }
bool isAtLeaf(const TraversalState traversal) {
  return (traversal.next & kRefLeaf) != 0u && traversal.next < kRefNext;
}

// Goes through the tree. Leaves and nodes have loops of their own: lavapipe 22.3 executes both sides of every branch,
// but leaves a loop when no lane is in it. It looks for that at the loop's end; a condition at the loop's head would cost it
// one more turn with no lane in it (docs/kernel.md, Loops).
void traverseTree(const Ray ray, const RayFactors factors, const bool anyHit, const uint kind, const float reach,
                  inout TraversalState traversal, inout int budget) {
  if (traversal.next == kRefNone || budget <= 0) return;
  do {
    if (LOOPS_AT_HEAD && (traversal.next == kRefNone || budget <= 0)) break;
    budget -= 3;  // this turn, and those of the loops inside that no lane takes
    if (traversal.next == kRefNext) popNode(traversal);
    if (traversal.next == kRefNext) takeEntry(traversal, traversal.tMax * reach);
    if (isAtNode(traversal) && budget > 0) {
      do {
        if (LOOPS_AT_HEAD && (!isAtNode(traversal) || budget <= 0)) break;
        --budget;
        visitNode(ray, factors, traversal);
        if (COUNTERS) ++nodesVisited[kind];
      } while (LOOPS_AT_HEAD || (isAtNode(traversal) && budget > 0));
    }
    if (isAtLeaf(traversal) && budget > 0) {
      do {
        if (LOOPS_AT_HEAD && (!isAtLeaf(traversal) || budget <= 0)) break;
        --budget;
        bool both;
        uint type = typeOf(traversal.next);
        bool taken = intersectPrimitive(ray, factors, traversal.next & kRefPrimitive, type, anyHit, kind, traversal,
                                        both);
        nextPrimitive(type, both, traversal);
        if (anyHit && taken) traversal.next = kRefNone;
      } while (LOOPS_AT_HEAD || (traversal.next < kRefNext && budget > 0));
    }
  } while (LOOPS_AT_HEAD || (traversal.next != kRefNone && budget > 0));
}

// Whether nothing is left of a list up to `end`.
bool isBehindList(const TraversalState traversal, const uint end) {
  return traversal.next == kRefNone || (traversal.next == kRefNext && traversal.list.first >= end);
}

// Goes through the primitives of one type in a list, from its next entry to `end`. Of the last pair the second triangle
// may be left: traversal.next names it.
void traversePrimitives(const Ray ray, const RayFactors factors, const uint type, const uint end, const bool anyHit,
                        const uint kind, const float reach, inout TraversalState traversal, inout int budget) {
  if (isBehindList(traversal, end) || budget <= 0) return;
  do {
    if (LOOPS_AT_HEAD && (isBehindList(traversal, end) || budget <= 0)) break;
    --budget;
    ListEntry entry = listEntryAt(traversal.list.first);
    bool again = type == kPairs && traversal.next != kRefNext;
    bool within = again || entry.distance <= traversal.tMax * reach;
    uint primitive = again ? traversal.next : entry.reference & kRefPrimitive;
    if (!again) traversal.list.first = within ? traversal.list.first + 1u : end;
    traversal.next = kRefNext;
    if (within) {
      bool both;
      bool taken = intersectPrimitive(ray, factors, primitive, type, anyHit, kind, traversal, both);
      if (type == kPairs && both) traversal.next = primitive | kRefSecond;
      if (anyHit && taken) traversal.next = kRefNone;
    }
  } while (LOOPS_AT_HEAD || (!isBehindList(traversal, end) && budget > 0));
}

// Goes along a list that holds no nodes: its spheres, its cones, its pairs.
void traverseCellList(const Ray ray, const RayFactors factors, const bool anyHit, const uint kind, const float reach,
                      inout TraversalState traversal, inout int budget) {
  uint firstCone = CONES ? traversal.list.firstCone : traversal.list.firstPair;
  if (SPHERES && traversal.list.first < firstCone)
    traversePrimitives(ray, factors, kSpheres, firstCone, anyHit, kind, reach, traversal, budget);
  if (CONES && traversal.list.first >= firstCone && traversal.list.first < traversal.list.firstPair)
    traversePrimitives(ray, factors, kCones, traversal.list.firstPair, anyHit, kind, reach, traversal, budget);
  if (TRIANGLES && traversal.list.first >= traversal.list.firstPair)
    traversePrimitives(ray, factors, kPairs, traversal.list.end, anyHit, kind, reach, traversal, budget);
  if (traversal.list.first >= traversal.list.end && traversal.next == kRefNext) traversal.next = kRefNone;
}

// Goes on until the traversal is finished or the budget of iterations is spent. An `anyHit` traversal ends at its first
// hit. `reach` = abs(direction along the face axis); list entries are sorted by depth along that axis, t * reach.
void traverse(const Ray given, const RayFactors factors, const bool anyHit, const bool visitsNodes, const uint kind,
              float reach, inout TraversalState traversal, inout int budget) {
  // The kernel's rounding is less than this.
  reach *= 1.0 + 1.0 / 262144.0;
  Ray ray = given;
#ifdef EDITED
  ray = trueStart(given);
  if (traversal.next == kRefBegin) traversal = checkedStart(ray, factors, anyHit, visitsNodes, traversal);
  // Begun at a node or a leaf by hand. (The second triangle of a pair in a list has other bits.)
  bool isInTree =
      traversal.next <= kRefOffsetMask || ((traversal.next & kRefLeaf) != 0u && traversal.next < kRefBegin);
  LACKS(NearestNodes, !visitsNodes && isInTree && !anyHit);
  LACKS(ShadowNodes, !visitsNodes && isInTree && anyHit);
#endif
  if (visitsNodes)
    traverseTree(ray, factors, anyHit, kind, reach, traversal, budget);
  else
    traverseCellList(ray, factors, anyHit, kind, reach, traversal, budget);
}
