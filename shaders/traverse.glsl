// A ray's walk: along the list of its cell, and from there through the tree of boxes. In: a ray and where its walk
// stands. Out: the same, farther on; the nearest primitive, or for a shadow ray any.

struct Walk {
  uint next;   // what to visit next; kRefNone: the walk is over
  uint top;    // entries on the node stack
  float tMax;  // distance of the best hit so far; before the first, how far the ray reaches
  uint hit;    // the best primitive so far (kind and place), or kRefNone
  uint order;  // its precedence
  uvec3 list;  // the rest of its list: next entry, end, and where pairs begin if spheres come first
  // Where solids touch, a second walk gathers all that is in one place with the nearest hit.
  float first;  // t of that hit
  float apart;  // how far the place reaches behind it; 0: the nearest hit is still looked for, and hitT is tMax
  float hitT;   // then t of the best hit in the place, which is the one of the lowest precedence; before, how far the
                // place of the nearest hit will reach, 0 if that is no wall of a solid
  uvec4 place;  // the walls there (solids.glsl)
};

// References still to be visited. A path through the tree leaves at most one on each level.
uint nodeStack[kMaxTreeDepth];

// A ray from anywhere walks the whole tree.
Walk walkFromRoot() { return Walk(root, 0u, kNoHit, kRefNone, 0u, uvec3(0u), 0.0, 0.0, 0.0, uvec4(0u)); }

// Whether the walk has found a nearest hit on a wall of a solid, and not yet what else is in its place.
bool lacksPlace(const Walk walk) {
  return SOLIDS && walk.apart == 0.0 && walk.hit != kRefNone && walk.hitT > 0.0;
}

// Goes through the tree once more, for all that is in one place with the nearest hit.
Walk walkThroughPlace(const Walk nearest) {
  float apart = nearest.hitT;
  return Walk(root, 0u, nearest.tMax + apart, kRefNone, kRefNone, uvec3(0u), nearest.tMax, apart, nearest.tMax, uvec4(0u));
}

// A ray through the middle of a cube walks the list of its cell.
Walk walkAlongList(const uvec3 list, const float tMax) {
  return Walk(kRefNext, 0u, tMax, kRefNone, 0u, list, 0.0, 0.0, 0.0, uvec4(0u));
}

uint unitsOf(const bool isPair) { return isPair ? kPairUnits : kSphereUnits; }

bool isOver(const Walk walk) { return walk.next == kRefNone; }

// The walk's next reference from its stack, if there is one.
void popNode(inout Walk walk) {
  walk.next = kRefNext;
  if (walk.top > 0u) {
    --walk.top;
    walk.next = nodeStack[walk.top];
  }
}

// An entry of a list: a reference, and the least distance at which the ray may meet it.
uvec2 listEntry(const uint index) {
  Row row = ROW(cubes, index >> 1u);
  return (index & 1u) != 0u ? row.zw : row.xy;
}

// The next entry of the list. Entries are sorted: behind what is beyond the limit everything is.
void takeEntry(inout Walk walk, const float limit) {
  uvec2 entry = listEntry(walk.list.x);
  walk.next = walk.list.x < walk.list.y && uintBitsToFloat(entry.y) <= limit ? entry.x : kRefNone;
  ++walk.list.x;
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
void visitNode(const Ray ray, const RayFactors factors, inout Walk walk) {
  Row origin = ROW(nodes, kNodeRows * walk.next + kNodeOrigin);
  Row planes = ROW(nodes, kNodeRows * walk.next + kNodePlanes);
  // t of a plane is (origin + byte * scale - ray.origin) / direction.
  vec3 scale = uintBitsToFloat((uvec3(origin.w) << uvec3(23u, 15u, 7u)) & 0x7f800000u) * factors.inverse;
  vec3 start = (xyz(origin) - ray.origin) * factors.inverse;
  float enter0 = enterBox(planesAt(planes.xyz, factors.nearShift) * scale + start,
                          planesAt(planes.xyz, 8u - factors.nearShift) * scale + start, walk.tMax);
  float enter1 = enterBox(planesAt(planes.xyz, factors.nearShift + 16u) * scale + start,
                          planesAt(planes.xyz, 24u - factors.nearShift) * scale + start, walk.tMax);

  // The references of both children, see Node in layout.h.
  uint below = walk.next + 1u, tags = origin.w >> 24u;
  uint firstCount = ((planes.w >> kRefCountShift) & kRefCountMask) + 1u;
  uint secondPlace = (planes.w & kRefPlaceMask) + firstCount * unitsOf(isOfTriangles(planes.w));
  uint secondLeaf = kRefLeaf | ((tags << 26u) & 0x70000000u) | secondPlace;
  uint child0 = (tags & 1u) != 0u ? planes.w : below;
  uint child1 = (tags & 1u) == 0u ? planes.w : (tags & 2u) == 0u ? below : secondLeaf;

  bool firstIsNearer = enter0 <= enter1;
  walk.next = firstIsNearer ? child0 : child1;
  bool both = max(enter0, enter1) < kNoHit, neither = min(enter0, enter1) == kNoHit;
  if (both) {
    nodeStack[walk.top] = firstIsNearer ? child1 : child0;
    ++walk.top;
  }
  if (neither) walk.next = kRefNext;
}

// What a ray meets of a shape.
struct Meeting {
  float t;         // kNoHit: nothing
  uint primitive;  // the sphere, or that triangle of the pair
  uint order;      // its precedence
  bool both;       // it passes both triangles, and this is the first: the second is still to be met
  uint tested;     // spheres or triangles that this took, for the counters
  uint wall;       // of a solid: that wall, or 0
  float apart;     // how far from t another wall may be hit that is in the same place
};

// Two walls are in one place if they are no farther apart than 48 roundings of their distance from the eye: that is more
// than how far rays start from a surface, with much room for the errors of both distances, so that these rarely decide.
float apartAlong(const vec3 point, const float margin, const float cosine) {
  return max(48.0 * kRounding * length(point), 4.0 * margin) / max(abs(cosine), 1.0 / 1024.0);
}

Meeting meetSphere(const Ray ray, const RayFactors factors, const uint primitive) {
  uint row = kUnitRows * primitive;
  Row center = ROW(primitives, row + kSphereCenter), tags = ROW(primitives, row + kSphereTags);
  bool leavesIt = (ray.leaving & ~kLeavesInward) == primitive;
  SphereRows sphere = sphereOf(center, tags);
  Meeting met = Meeting(hitSphere(ray, factors, sphere, leavesIt), primitive, tags.x, false, 1u, 0u, 0.0);
  if (SOLIDS && met.t < kNoHit) {
    bool outside = !leavesIt && isOutside(sphere, ray.origin);
    met.wall = wallOf(tags.y & ~kNearEye, outside != (sphere.radius < 0.0));
    vec3 point = ray.origin + met.t * ray.direction;
    met.apart = apartAlong(point, sphereMargin(sphere, point), dot(normalize(point - sphere.center), ray.direction));
  }
  return met;
}

// `pair` has kRefSecond where the first triangle has been met already.
Meeting meetPair(const Ray ray, const RayFactors factors, const uint pair) {
  uint row = kUnitRows * (pair & kRefPlaceMask);
  Row v0 = ROW(primitives, row + kPairV0), v1 = ROW(primitives, row + kPairV1), v2 = ROW(primitives, row + kPairV2),
      v3 = ROW(primitives, row + kPairV3);
  vec3 a = sheared(ray, factors, xyz(v0)), b = sheared(ray, factors, xyz(v1)), c = sheared(ray, factors, xyz(v2)),
       d = sheared(ray, factors, xyz(v3));
  float across = edgeArea(b, c);  // of the edge that both share
  uint first = pair & ~kRefSecond, second = pair | kRefSecond, leaving = ray.leaving & ~kLeavesInward;
  bool inFirst = isInside(across, edgeArea(c, a), edgeArea(a, b)) && leaving != first && pair == first;
  bool inSecond = isInside(-across, edgeArea(b, d), edgeArea(d, c)) && leaving != second;

  // One plane at a time: that both are met is rare. Where none is, no other memory is touched.
  bool isSecond = inSecond && !inFirst;
  uint planeRow = row + kPairNormals + uint(isSecond);
  Row plane = ROW(primitives, inFirst || inSecond ? planeRow : row);
  float apex = isSecond ? d.z : a.z;
  float tNear = lesser(lesser(b.z, c.z), apex), tFar = greater(greater(b.z, c.z), apex);
  vec3 nearest = tNear == b.z ? xyz(v1) : tNear == c.z ? xyz(v2) : isSecond ? xyz(v3) : xyz(v0);
  float t = planeDistance(ray, xyz(plane), uintBitsToFloat(plane.w), nearest, tNear, tFar);
  if (!(inFirst || inSecond) || !(t > 0.0)) t = kNoHit;
  uint tested = pair != first ? 0u : v3.w != kRefNone ? 2u : 1u;
  uint wall = 0u;
  float apart = 0.0;
  if (SOLIDS && t < kNoHit) {
    wall = wallOf(v1.w, dot(xyz(plane), ray.direction) < 0.0);
    vec3 point = ray.origin + t * ray.direction;
    apart = apartAlong(point, planeMargin(xyz(plane), uintBitsToFloat(plane.w), point), dot(xyz(plane), ray.direction));
  }
  return Meeting(t, isSecond ? second : first, isSecond ? v3.w : v0.w, inFirst && inSecond, tested, wall, apart);
}

// Tests a shape; true if it takes the walk's hit. Among equal distances the lowest precedence wins, so that the picture
// does not depend on the tree.
bool visitShape(const Ray ray, const RayFactors factors, const uint shape, const bool isPair, const bool anyHit,
                const uint kind, inout Walk walk, out bool both) {
  Meeting met = Meeting(kNoHit, kRefNone, 0u, false, 0u, 0u, 0.0);
  if (SPHERES && !isPair) met = meetSphere(ray, factors, shape);
  if (TRIANGLES && isPair) met = meetPair(ray, factors, shape);
  bool taken = met.t < walk.tMax;
  if (!anyHit) taken = taken || (met.t == walk.tMax && walk.hit != kRefNone && met.order < walk.order);
  bool gathers = SOLIDS && !anyHit && walk.apart > 0.0;
  if (gathers) {
    // What is no wall of a solid is no more than roundings away from what it touches.
    bool inPlace = met.t <= walk.first + (met.wall != 0u ? walk.apart : 0.25 * walk.apart);
    if (inPlace) walk.place = withWall(walk.place, met.wall);
    taken = inPlace && met.order < walk.order;
    if (taken) walk.hitT = met.t;
  } else if (taken && !anyHit) {
    walk.tMax = met.t;
    // Of the nearest hit so far: whether it is a wall, and how far its place will reach.
    if (SOLIDS) walk.hitT = met.wall != 0u ? met.apart : 0.0;
  }
  if (taken) walk.hit = met.primitive;
  if (taken && !anyHit) walk.order = met.order;
  both = met.both;
  if (COUNTERS) primitivesVisited[kind] += met.tested;
  return taken;
}

// On to the leaf's next shape, or to whatever follows the leaf.
void passShape(const bool isPair, const bool both, inout Walk walk) {
  bool last = ((walk.next >> kRefCountShift) & kRefCountMask) == 0u;
  uint following = last ? kRefNext : (walk.next & ~kRefSecond) + unitsOf(isPair) - (1u << kRefCountShift);
  walk.next = both ? walk.next | kRefSecond : following;
}

// The turns that a walk's loops make with no lane in them: lavapipe 22.3 runs the body of every loop at least once.
// Whoever calls continueWalk, or has other lanes call it, pays for them.
int idleTurns(const bool meetsNodes) { return meetsNodes ? 3 : int(SPHERES) + int(TRIANGLES); }

// Goes through the tree. Leaves and nodes have loops of their own: lavapipe 22.3 executes both sides of every branch, but
// leaves a loop when no lane is in it. It looks for that at the loop's end; a condition at the loop's head would cost it
// one more turn with no lane in it.
void walkTree(const Ray ray, const RayFactors factors, const bool anyHit, const uint kind, const float reach,
              inout Walk walk, inout int budget) {
  if (walk.next == kRefNone || budget <= 0) return;
  do {
    budget -= 3;  // this turn, and those of the loops inside that no lane takes
    if (walk.next == kRefNext) popNode(walk);
    if (walk.next == kRefNext) takeEntry(walk, walk.tMax * reach);
    if ((walk.next & kRefLeaf) == 0u && budget > 0) {
      do {
        --budget;
        visitNode(ray, factors, walk);
        if (COUNTERS) ++nodesVisited[kind];
      } while ((walk.next & kRefLeaf) == 0u && budget > 0);
    }
    if ((walk.next & kRefLeaf) != 0u && walk.next < kRefNext && budget > 0) {
      do {
        --budget;
        bool both, arePairs = isOfTriangles(walk.next);
        bool taken = visitShape(ray, factors, walk.next & kRefPrimitive, arePairs, anyHit, kind, walk, both);
        passShape(arePairs, both, walk);
        if (anyHit && taken) walk.next = kRefNone;
      } while (walk.next < kRefNext && budget > 0);
    }
  } while (walk.next != kRefNone && budget > 0);
}

// Goes through the spheres or the pairs of a list, from its next entry to `end`. Of the last pair the second triangle may
// be left: walk.next names it.
void walkShapes(const Ray ray, const RayFactors factors, const bool arePairs, const uint end, const bool anyHit,
                const uint kind, const float reach, inout Walk walk, inout int budget) {
  if (walk.next == kRefNone || (walk.next == kRefNext && walk.list.x >= end) || budget <= 0) return;
  do {
    --budget;
    uvec2 entry = listEntry(walk.list.x);
    bool again = arePairs && walk.next != kRefNext;
    bool within = again || uintBitsToFloat(entry.y) <= walk.tMax * reach;
    uint shape = again ? walk.next : entry.x & kRefPrimitive;
    if (!again) walk.list.x = within ? walk.list.x + 1u : end;
    walk.next = kRefNext;
    if (within) {
      bool both;
      bool taken = visitShape(ray, factors, shape, arePairs, anyHit, kind, walk, both);
      if (arePairs && both) walk.next = shape | kRefSecond;
      if (anyHit && taken) walk.next = kRefNone;
    }
  } while (walk.next != kRefNone && (walk.next != kRefNext || walk.list.x < end) && budget > 0);
}

// Goes along a list that holds no nodes, its spheres before its pairs.
void walkList(const Ray ray, const RayFactors factors, const bool anyHit, const uint kind, const float reach,
              inout Walk walk, inout int budget) {
  if (SPHERES && walk.list.x < walk.list.z)
    walkShapes(ray, factors, false, walk.list.z, anyHit, kind, reach, walk, budget);
  if (TRIANGLES && walk.list.x >= walk.list.z)
    walkShapes(ray, factors, true, walk.list.y, anyHit, kind, reach, walk, budget);
  if (walk.list.x >= walk.list.y && walk.next == kRefNext) walk.next = kRefNone;
}

// Walks on until the walk is over or the budget of iterations is spent. An `anyHit` walk ends at its first hit. `reach`
// turns a distance along the ray into one along the cube's face.
void continueWalk(const Ray ray, const RayFactors factors, const bool anyHit, const bool meetsNodes, const uint kind,
                  float reach, inout Walk walk, inout int budget) {
  // The kernel's rounding is less than this.
  reach *= 1.0 + 1.0 / 262144.0;
  if (meetsNodes)
    walkTree(ray, factors, anyHit, kind, reach, walk, budget);
  else
    walkList(ray, factors, anyHit, kind, reach, walk, budget);
}
