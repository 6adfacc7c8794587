// A ray's walk: along the list of its cell, and from there through the tree of boxes. In: a ray and where its walk
// stands. Out: the same, farther on; the nearest primitive, or for a shadow ray any.

struct Walk {
  uint next;   // what to visit next; kRefNone: the walk is over
  uint top;    // entries on the node stack
  float tMax;  // distance of the best hit so far; before the first, how far the ray reaches
  uint hit;    // the best primitive so far (kind and place), or kRefNone
  uint hitId;  // its id
  uvec3 list;  // the rest of its list: next entry, end, and where triangles begin if spheres come first
};

// References still to be visited. A path through the tree leaves at most one on each level.
uint nodeStack[kMaxTreeDepth];

// A ray from anywhere walks the whole tree.
Walk walkFromRoot() { return Walk(root, 0u, kNoHit, kRefNone, 0u, uvec3(0u)); }

// A ray through the middle of a cube walks the list of its cell.
Walk walkAlongList(uvec3 list, float tMax) { return Walk(kRefNext, 0u, tMax, kRefNone, 0u, list); }

bool isOver(Walk walk) { return walk.next == kRefNone; }

// The walk's next reference from its stack, if there is one.
void popNode(inout Walk walk) {
  walk.next = kRefNext;
  if (walk.top > 0u) {
    --walk.top;
    walk.next = nodeStack[walk.top];
  }
}

// An entry of a list: a reference, and the least distance at which the ray may meet it.
uvec2 listEntry(uint index) {
  Row row = ROW(cubes, index >> 1u);
  return (index & 1u) != 0u ? row.zw : row.xy;
}

// The next entry of the list. Entries are sorted: behind what is beyond the limit everything is.
void takeEntry(inout Walk walk, float limit) {
  uvec2 entry = listEntry(walk.list.x);
  walk.next = walk.list.x < walk.list.y && uintBitsToFloat(entry.y) <= limit ? entry.x : kRefNone;
  ++walk.list.x;
}

// Where a ray enters one of a node's boxes, or kNoHit if it does not before tMax. `near` and `far` hold the planes that
// it meets first and last on each axis. The interval is widened by 2^-20: Vulkan allows a division 2.5 ulp of error, for
// which the usual 3 ulp do not suffice (Ize, JCGT 2(2), 2013).
float enterBox(vec3 near, vec3 far, float tMax) {
  float enter = greater(greater(near.x, near.y), greater(near.z, 0.0)) * (1.0 - 1.0 / 1048576.0);
  float leave = lesser(lesser(far.x, far.y), lesser(far.z, tMax));
  return enter <= leave * (1.0 + 1.0 / 1048576.0) ? enter : kNoHit;
}

// Four planes are the bytes of an integer; this takes one of each axis.
vec3 planesAt(uvec3 planes, uvec3 shift) { return vec3(ivec3((planes >> shift) & 255u)); }

// Goes on with the nearer child that the ray enters; the other one waits on the stack.
void visitNode(Ray ray, RayFactors factors, inout Walk walk) {
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
  uint secondLeaf = kRefLeaf | ((tags << 26u) & 0x70000000u) | ((planes.w & kRefPlaceMask) + 1u + (tags >> 5u));
  uint child0 = (tags & 1u) != 0u ? planes.w : below;
  uint child1 = (tags & 1u) == 0u ? planes.w : (tags & 2u) == 0u ? below : secondLeaf;

  bool firstIsNearer = enter0 <= enter1;
  walk.next = firstIsNearer ? child0 : child1;
  bool both = max(enter0, enter1) < kNoHit, neither = min(enter0, enter1) == kNoHit;
  if (both) {
    nodeStack[walk.top] = firstIsNearer ? child1 : child0;
    ++walk.top;
  }
  if (neither) popNode(walk);
}

// The distance to a primitive, and its id.
float meetPrimitive(Ray ray, RayFactors factors, uint primitive, bool isTriangle, out uint id) {
  uint row = kUnitRows * (primitive & kRefPlaceMask);
  bool leavesIt = (ray.leaving & ~kLeavesInward) == primitive;
  Row row0 = ROW(primitives, row), row1 = ROW(primitives, row + 1u);
  float t = kNoHit;
  if (SPHERES && !isTriangle) {
    t = hitSphere(ray, factors, xyz(row0), uintBitsToFloat(row0.w), leavesIt);
    id = row1.x;
  }
  if (TRIANGLES && isTriangle) {
    Row row2 = ROW(primitives, row + kTriangleV2), plane = ROW(primitives, row + kTriangleNormal);
    Edges edges = triangleEdges(ray, factors, xyz(row0), xyz(row1), xyz(row2));
    float distance = planeDistance(ray, edges, xyz(plane), uintBitsToFloat(plane.w));
    if (edges.inside && !leavesIt && distance > 0.0) t = distance;
    id = row0.w;
  }
  return t;
}

// Tests a primitive; true if it takes the walk's hit. Among equal distances the lowest id wins, so that the picture does
// not depend on the tree.
bool visitPrimitive(Ray ray, RayFactors factors, uint primitive, bool isTriangle, bool anyHit, inout Walk walk) {
  uint id = 0u;
  float t = meetPrimitive(ray, factors, primitive, isTriangle, id);
  bool taken = t < walk.tMax;
  if (!anyHit) taken = taken || (t == walk.tMax && walk.hit != kRefNone && id < walk.hitId);
  if (taken) walk.hit = primitive;
  if (taken && !anyHit) {
    walk.tMax = t;
    walk.hitId = id;
  }
  return taken;
}

// On to the leaf's next primitive, or away from the leaf.
void passPrimitive(inout Walk walk) {
  bool last = ((walk.next >> kRefCountShift) & kRefCountMask) == 0u;
  walk.next += ((walk.next & kRefTriangle) != 0u ? 2u : 1u) - (1u << kRefCountShift);
  if (last) popNode(walk);
}

// The turns that a walk's loops make with no lane in them: lavapipe 22.3 runs the body of every loop at least once.
// Whoever calls continueWalk, or has other lanes call it, pays for them.
int idleTurns(bool meetsNodes) { return meetsNodes ? 3 : int(SPHERES) + int(TRIANGLES); }

// Goes through the tree. Leaves and nodes have loops of their own: lavapipe 22.3 executes both sides of every branch, but
// leaves a loop when no lane is in it. It looks for that at the loop's end; a condition at the loop's head would cost it
// one more turn with no lane in it.
void walkTree(Ray ray, RayFactors factors, bool anyHit, uint kind, float reach, inout Walk walk, inout int budget) {
  if (walk.next == kRefNone || budget <= 0) return;
  do {
    budget -= 3;  // this turn, and those of the loops inside that no lane takes
    if ((walk.next & kRefLeaf) != 0u && budget > 0) {
      do {
        --budget;
        if (walk.next != kRefNext) {
          bool isTriangle = TRIANGLES && (!SPHERES || (walk.next & kRefTriangle) != 0u);
          uint primitive = walk.next & (kRefTriangle | kRefPlaceMask);
          bool taken = visitPrimitive(ray, factors, primitive, isTriangle, anyHit, walk);
          passPrimitive(walk);
          if (anyHit && taken) walk.next = kRefNone;
          if (COUNTERS) ++primitivesVisited[kind];
        }
        if (walk.next == kRefNext) takeEntry(walk, walk.tMax * reach);
      } while ((walk.next & kRefLeaf) != 0u && walk.next != kRefNone && budget > 0);
    }
    if ((walk.next & kRefLeaf) == 0u && budget > 0) {
      do {
        --budget;
        visitNode(ray, factors, walk);
        if (COUNTERS) ++nodesVisited[kind];
      } while ((walk.next & kRefLeaf) == 0u && budget > 0);
    }
  } while (walk.next != kRefNone && budget > 0);
}

// Goes through the spheres or the triangles of a list, from its next entry to `end`.
void walkPrimitives(Ray ray, RayFactors factors, bool areTriangles, uint end, bool anyHit, uint kind, float reach,
                    inout Walk walk, inout int budget) {
  if (walk.list.x >= end || walk.next == kRefNone || budget <= 0) return;
  do {
    --budget;
    uvec2 entry = listEntry(walk.list.x);
    bool within = uintBitsToFloat(entry.y) <= walk.tMax * reach;
    walk.list.x = within ? walk.list.x + 1u : end;
    if (within) {
      uint primitive = entry.x & (kRefTriangle | kRefPlaceMask);
      bool taken = visitPrimitive(ray, factors, primitive, areTriangles, anyHit, walk);
      if (anyHit && taken) walk.next = kRefNone;
      if (COUNTERS) ++primitivesVisited[kind];
    }
  } while (walk.list.x < end && walk.next != kRefNone && budget > 0);
}

// Goes along a list that holds no nodes, its spheres before its triangles.
void walkList(Ray ray, RayFactors factors, bool anyHit, uint kind, float reach, inout Walk walk, inout int budget) {
  if (SPHERES) walkPrimitives(ray, factors, false, walk.list.z, anyHit, kind, reach, walk, budget);
  if (TRIANGLES && walk.list.x >= walk.list.z)
    walkPrimitives(ray, factors, true, walk.list.y, anyHit, kind, reach, walk, budget);
  if (walk.list.x >= walk.list.y) walk.next = kRefNone;
}

// Walks on until the walk is over or the budget of iterations is spent. An `anyHit` walk ends at its first hit. `reach`
// turns a distance along the ray into one along the cube's face.
void continueWalk(Ray ray, RayFactors factors, bool anyHit, bool meetsNodes, uint kind, float reach, inout Walk walk,
                  inout int budget) {
  // The kernel's rounding is less than this.
  reach *= 1.0 + 1.0 / 262144.0;
  if (meetsNodes)
    walkTree(ray, factors, anyHit, kind, reach, walk, budget);
  else
    walkList(ray, factors, anyHit, kind, reach, walk, budget);
}
