// Walks the tree of boxes along one ray, a bounded number of steps at a time. In: a ray and where its walk stands. Out:
// the same, farther on; the nearest primitive, or for a shadow ray any.

struct Walk {
  uint next;   // reference to visit next; kRefNone: the walk is over
  uint top;    // entries on the stack
  float tMax;  // distance of the best hit so far; before the first, how far the ray reaches
  uint hit;    // the best primitive so far (kind and index), or kRefNone
};

// References still to be visited. A path through the tree leaves at most one on each level.
uint nodeStack[kMaxTreeDepth];

Walk beginWalk(float tMax) { return Walk(frame.centreHi.w, 0u, tMax, kRefNone); }

uint primitiveId(uint primitive) {
  uint index = primitive & kRefIndexMask;
  if (SPHERES && TRIANGLES)
    return (primitive & kRefTriangle) != 0u ? triangles[index].v0.w : spheres[index].tags.x;
  return TRIANGLES ? triangles[index].v0.w : spheres[index].tags.x;
}

// Takes the hit if it is nearer; among equals the lowest id wins, so that the picture does not depend on the tree.
void takeHit(inout Walk walk, float t, uint primitive) {
  bool nearer = t < walk.tMax;
  if (t == walk.tMax && walk.hit != kRefNone) nearer = primitiveId(primitive) < primitiveId(walk.hit);
  if (nearer) {
    walk.tMax = t;
    walk.hit = primitive;
  }
}

// Tests one primitive of the leaf `walk.next`.
void visitPrimitive(Ray ray, RayFactors factors, inout Walk walk) {
  uint primitive = walk.next & (kRefTriangle | kRefIndexMask);
  uint index = walk.next & kRefIndexMask;
  bool leavesIt = (ray.leaving & ~kLeavesInward) == primitive;
  bool isTriangle = (walk.next & kRefTriangle) != 0u;
  float t = kNoHit;
  if (SPHERES && !isTriangle) {
    Row center = spheres[index].center;
    t = hitSphere(ray, xyz(center), uintBitsToFloat(center.w), leavesIt);
  }
  if (TRIANGLES && isTriangle && !leavesIt) {
    vec3 v0 = xyz(triangles[index].v0), v1 = xyz(triangles[index].v1), v2 = xyz(triangles[index].v2);
    Edges edges = triangleEdges(ray, factors, v0, v1, v2);
    if (edges.inside) {
      Row plane = triangles[index].normal;
      t = planeDistance(ray, edges, xyz(plane), uintBitsToFloat(plane.w));
      if (t <= 0.0) t = kNoHit;
    }
  }
  takeHit(walk, t, primitive);
}

// Makes at most STEPS steps; each visits one node or one primitive. An `anyHit` walk ends at its first hit.
void continueWalk(Ray ray, bool anyHit, inout Walk walk) {
  RayFactors factors = rayFactors(ray.direction);
  for (uint steps = 0u; steps < STEPS && walk.next != kRefNone; ++steps) {
    bool popNext = false;
    if ((walk.next & kRefLeaf) == 0u) {
      Row lo0 = nodes[walk.next].lo0, hi0 = nodes[walk.next].hi0;
      Row lo1 = nodes[walk.next].lo1, hi1 = nodes[walk.next].hi1;
      float enter0 = enterBox(ray.origin, factors.inverse, walk.tMax, xyz(lo0), xyz(hi0));
      float enter1 = enterBox(ray.origin, factors.inverse, walk.tMax, xyz(lo1), xyz(hi1));
      bool firstIsNearer = enter0 <= enter1;
      uint nearer = firstIsNearer ? lo0.w : hi0.w, farther = firstIsNearer ? hi0.w : lo0.w;
      if (max(enter0, enter1) < kNoHit) {
        nodeStack[walk.top] = farther;
        ++walk.top;
      }
      walk.next = nearer;
      popNext = min(enter0, enter1) == kNoHit;
    } else {
      visitPrimitive(ray, factors, walk);
      // On to the leaf's next primitive: its index plus one, its count less one.
      popNext = ((walk.next >> kRefCountShift) & kRefCountMask) == 0u;
      walk.next += 1u - (1u << kRefCountShift);
      if (anyHit && walk.hit != kRefNone) {
        walk.top = 0u;
        popNext = true;
      }
    }
    if (popNext) {
      walk.next = kRefNone;
      if (walk.top > 0u) {
        --walk.top;
        walk.next = nodeStack[walk.top];
      }
    }
  }
}
