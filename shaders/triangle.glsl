// A ray against a pair of triangles, and the surface there. In: the ray and the pair. Out: the distance, in units of the
// ray's direction.

// A vertex as the ray sees it (Woop, Benthin, Wald, JCGT 2(1), 2013): x and y across the ray, z its distance, measured
// along the ray's largest component.
vec3 sheared(const Ray ray, const RayFactors factors, const vec3 vertex) {
  precise vec3 v = turn(vertex - ray.origin, factors.axis);
  precise vec2 across = v.xy - factors.shear.xy * v.z;
  return vec3(across, v.z * factors.shear.z);
}

// The signed area between the ray and an edge of sheared vertices. Watertight without a wider type: each product is
// rounded by itself, so that the difference has the right sign or is 0, and the neighbour across the edge, who has the
// ends in the other order, gets exactly the opposite.
float edgeArea(const vec3 from, const vec3 to) {
  precise float area = to.x * from.y - to.y * from.x;
  return area;
}

// Whether the ray passes a triangle of these areas: on the same side of all edges, and not edge-on.
bool isInside(const float u, const float v, const float w) {
  precise float det = u + v + w;
  bool outside = lesser(lesser(u, v), w) < 0.0 && greater(greater(u, v), w) > 0.0;
  return !outside && det != 0.0;
}

// Distance to a triangle's plane, which is better than the one that the edges give: on thin triangles by far, and beside
// the eye of a huge one. Kept between the vertices, because the plane of a triangle seen nearly edge-on tells nothing.
// The origin's height under the plane comes from whichever is nearer: the nearest vertex (of a small triangle far from
// the eye), or the plane's offset, which is its distance from the eye.
float planeDistance(const Ray ray, const vec3 normal, const float offset, const vec3 vertex, const float tNear,
                    const float tFar) {
  vec3 way = vertex - ray.origin;
  precise float slope = dot(normal, ray.direction);
  precise float fromVertex = dot(normal, way);
  precise float fromEye = offset - dot(normal, ray.origin);
  bool isNear = dot(abs(way), vec3(1)) < dot(abs(ray.origin), vec3(1));
  precise float t = (isNear ? fromVertex : fromEye) / slope;
  if (slope == 0.0) t = tNear;
  return lesser(greater(t, tNear), tFar);
}

// How far from its surface a ray must start to be on one side of a plane and its coplanar neighbours: the point is rounded, both planes' N and d are, and so is every term
// of the neighbour's N.x. The errors of the terms add up to seven roundings of the sum of their sizes at the worst.
float planeErrorBound(const vec3 normal, const float offset, const vec3 point) {
  return 2.0 * kRounding * (dot(abs(normal), abs(point)) + abs(offset));
}

// `pair` has kRefSecond where the first triangle was tested already.
Intersection intersectTrianglePair(const Ray ray, const RayFactors factors, const uint pair) {
  uint offset = pair & kRefOffsetMask;
  TrianglePair packed = trianglePairAt(offset);
  vec3 a = sheared(ray, factors, packed.v0), b = sheared(ray, factors, packed.v1), c = sheared(ray, factors, packed.v2),
       d = sheared(ray, factors, packed.v3);
  float across = edgeArea(b, c);  // of the edge that both share
  uint first = pair & ~kRefSecond, second = pair | kRefSecond, originPrimitive = ray.originPrimitive & ~kStartsInward;
  bool inFirst = isInside(across, edgeArea(c, a), edgeArea(a, b)) && originPrimitive != first && pair == first;
  bool inSecond = isInside(-across, edgeArea(b, d), edgeArea(d, c)) && originPrimitive != second;

  // One plane at a time: that both are met is rare. Where none is, no other memory is touched.
  bool isSecond = inSecond && !inFirst;
  Plane plane = planeAt(offset, uint(isSecond), inFirst || inSecond);
  float apex = isSecond ? d.z : a.z;
  float tNear = lesser(lesser(b.z, c.z), apex), tFar = greater(greater(b.z, c.z), apex);
  vec3 nearest = tNear == b.z ? packed.v1 : tNear == c.z ? packed.v2 : isSecond ? packed.v3 : packed.v0;
  float t = planeDistance(ray, plane.normal, plane.offset, nearest, tNear, tFar);
  if (!(inFirst || inSecond) || !(t > 0.0)) t = kNoHit;
  uint tested = pair != first ? 0u : packed.rank1 != kRefNone ? 2u : 1u;
  uint interfaceId = 0u;
  float coincidence = 0.0;
  if (NESTED_DIELECTRICS && t < kNoHit) {
    float cosine = dot(plane.normal, ray.direction);
    interfaceId = interfaceOf(packed.material, cosine < 0.0);
    vec3 point = ray.origin + t * ray.direction;
    coincidence = coincidenceDistance(point, planeErrorBound(plane.normal, plane.offset, point), cosine);
  }
  return Intersection(t, isSecond ? second : first, isSecond ? packed.rank1 : packed.rank0, inFirst && inSecond, tested,
                      interfaceId, coincidence);
}

// The surface where a ray hits a triangle.
Surface triangleSurface(const Ray ray, const RayFactors factors, const float t, const uint primitive) {
  Surface surface;
  surface.outside = true;
  uint offset = primitive & kRefOffsetMask;
  bool isSecond = (primitive & kRefSecond) != 0u;
  Plane plane = planeAt(offset, uint(isSecond), true);
  TrianglePair pair = trianglePairAt(offset);
  surface.Ng = plane.normal;
  surface.material = pair.material;
  // Put the point back on the plane, as far as it can be rounded to it.
  vec3 point = ray.origin + t * ray.direction;
  surface.point =
      point - surface.Ng * wideSum(wideDot(surface.Ng, vec3(0), point, vec3(0)), vec2(-plane.offset, 0)).x;
  surface.errorBound = planeErrorBound(surface.Ng, plane.offset, surface.point);
  surface.Ns = surface.Ng;
  if (SMOOTH_NORMALS && pair.normals != kRefNone) {
    vec3 a = sheared(ray, factors, isSecond ? pair.v3 : pair.v0);
    vec3 b = sheared(ray, factors, isSecond ? pair.v2 : pair.v1);
    vec3 c = sheared(ray, factors, isSecond ? pair.v1 : pair.v2);
    precise vec3 areas = vec3(edgeArea(b, c), edgeArea(c, a), edgeArea(a, b));
    precise float det = areas.x + areas.y + areas.z;
    vec3 weights = areas / det;
    VertexNormals normals = vertexNormalsAt(pair.normals + uint(isSecond));
    vec3 Ns = weights.x * normals.n0 + weights.y * normals.n1 + weights.z * normals.n2;
    float squared = dot(Ns, Ns);
    if (squared > 0.0) surface.Ns = Ns * inversesqrt(squared);
    if (dot(surface.Ng, surface.Ns) < 0.0) surface.Ng = -surface.Ng;
  }
  surface.front = dot(surface.Ng, -ray.direction) > 0.0;
  if (!surface.front) {
    surface.Ng = -surface.Ng;
    surface.Ns = -surface.Ns;
  }
  return surface;
}
