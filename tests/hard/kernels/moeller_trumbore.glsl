// What --price puts in the place of intersectTrianglePair: Moeller and Trumbore's test (JGT 2(1), 1997) of both triangles of a pair.
// The edge that they share is tested twice, by different arithmetic.

// Distance to the triangle of a corner and two edges, or kNoHit.
float moellerTrumbore(const Ray ray, const vec3 corner, const vec3 e1, const vec3 e2) {
  vec3 p = cross(ray.direction, e2);
  float inverseDet = 1.0 / dot(e1, p);
  vec3 s = ray.origin - corner, q = cross(s, e1);
  float u = dot(s, p) * inverseDet, v = dot(ray.direction, q) * inverseDet, t = dot(e2, q) * inverseDet;
  // Written so that the NaN of a triangle seen edge-on is no hit.
  return lesser(u, v) >= 0.0 && u + v <= 1.0 && t > 0.0 ? t : kNoHit;
}

Intersection intersectTrianglePair(const Ray ray, const RayFactors factors, const uint pair) {
  TrianglePair packed = trianglePairAt(pair & kRefOffsetMask);
  vec3 a = packed.v0, b = packed.v1, c = packed.v2, d = packed.v3;
  uint first = pair & ~kRefSecond, second = pair | kRefSecond, originPrimitive = ray.originPrimitive & ~kStartsInward;
  float tFirst = moellerTrumbore(ray, a, b - a, c - a), tSecond = moellerTrumbore(ray, d, c - d, b - d);
  bool inFirst = tFirst < kNoHit && originPrimitive != first && pair == first;
  bool inSecond = tSecond < kNoHit && originPrimitive != second;
  bool isSecond = inSecond && !inFirst;
  float t = inFirst ? tFirst : inSecond ? tSecond : kNoHit;
  uint tested = pair != first ? 0u : packed.rank1 != kRefNone ? 2u : 1u;
  return Intersection(t, isSecond ? second : first, isSecond ? packed.rank1 : packed.rank0, inFirst && inSecond, tested, 0u, 0.0);
}
