// A ray against one box, sphere or triangle. In: the ray and the primitive's rows. Out: the distance, in units of the
// ray's direction. Ng, t and the other symbols are those of docs/light_transport.md.

const float kNoHit = 1e38;  // farther than everything, and still finite when an interval is widened

struct Ray {
  vec3 origin;
  vec3 direction;  // unit for eye and secondary rays; the way to the light for shadow rays
  uint leaving;    // the primitive it starts on, with kLeavesInward; kRefNone for an eye ray
};

// What a ray's direction gives to all its tests.
struct RayFactors {
  vec3 inverse;  // 1 / direction, for boxes
  int axis;      // of the largest component of the direction, for triangles
  vec3 shear;    // Woop's S_x, S_y, S_z
};

// The three components with axis z last, in cyclic order.
vec3 turn(vec3 v, int axis) { return axis == 0 ? v.yzx : axis == 1 ? v.zxy : v; }

RayFactors rayFactors(vec3 direction) {
  RayFactors factors;
  // A component near 0 becomes 1e-18, keeping its sign: 0 * inf would be NaN in a slab that holds the origin on its
  // plane, and Vulkan does not promise infinities. The boxes are padded, so that nothing is missed by it.
  vec3 magnitude = abs(direction);
  vec3 safe = mix(max(magnitude, 1e-18), -max(magnitude, 1e-18), lessThan(direction, vec3(0)));
  factors.inverse = 1.0 / safe;
  factors.axis = magnitude.x > magnitude.y ? (magnitude.x > magnitude.z ? 0 : 2) : (magnitude.y > magnitude.z ? 1 : 2);
  vec3 d = turn(direction, factors.axis);
  factors.shear = vec3(d.x / d.z, d.y / d.z, 1.0 / d.z);
  return factors;
}

// Where a ray enters a box, or kNoHit if it does not before tMax. The interval is widened by 2^-20: Vulkan allows a
// division 2.5 ulp of error, for which the usual 3 ulp do not suffice.
float enterBox(vec3 origin, vec3 inverse, float tMax, vec3 lo, vec3 hi) {
  vec3 t0 = (lo - origin) * inverse, t1 = (hi - origin) * inverse;
  vec3 tNear = min(t0, t1), tFar = max(t0, t1);
  float near = max(max(tNear.x, tNear.y), max(tNear.z, 0.0)) * (1.0 - 1.0 / 1048576.0);
  float far = min(min(tFar.x, tFar.y), min(tFar.z, tMax)) * (1.0 + 1.0 / 1048576.0);
  return near <= far ? near : kNoHit;
}

// Distance to a sphere, or kNoHit. The discriminant comes from the distance of the centre to the ray, and the smaller
// root from the product of the roots (Haines, Guenther, Akenine-Moeller, Ray Tracing Gems ch. 7).
float hitSphere(Ray ray, vec3 center, float radius, bool leavesIt) {
  vec3 f = ray.origin - center;
  float a = dot(ray.direction, ray.direction);
  float b = -dot(f, ray.direction);
  // A ray that starts on the sphere: one root is exactly 0, the other 2b/a. Outward it never returns, however grazing.
  if (leavesIt) return (ray.leaving & kLeavesInward) != 0u ? max(2.0 * b / a, 0.0) : kNoHit;
  vec3 perpendicular = f + (b / a) * ray.direction;
  float discriminant = radius * radius - dot(perpendicular, perpendicular);
  if (discriminant < 0.0) return kNoHit;
  float c = dot(f, f) - radius * radius;
  float root = sqrt(a) * sqrt(discriminant);  // a shadow ray is as long as its light is far: no product of squares
  float q = b >= 0.0 ? b + root : b - root;
  float t0 = c / q, t1 = q / a;  // one of them may be NaN if q is 0: a comparison with it is false
  float near = min(t0, t1), far = max(t0, t1);
  return near > 0.0 ? near : far > 0.0 ? far : kNoHit;
}

// The signed areas of a triangle's edges as the ray sees them (Woop, Benthin, Wald, JCGT 2(1), 2013). Watertight without
// a wider type: each product is rounded by itself, so that a difference has the right sign or is 0, and the neighbour
// across an edge gets exactly the opposite.
struct Edges {
  bool inside;
  vec3 weights;        // of the vertices, times det
  float det;           // 0: seen edge-on, not inside
  float tNear, tFar;   // distances of the nearest and the farthest vertex, measured along the ray's largest component
};

Edges triangleEdges(Ray ray, RayFactors factors, vec3 v0, vec3 v1, vec3 v2) {
  precise vec3 a = turn(v0 - ray.origin, factors.axis);
  precise vec3 b = turn(v1 - ray.origin, factors.axis);
  precise vec3 c = turn(v2 - ray.origin, factors.axis);
  precise vec2 as = a.xy - factors.shear.xy * a.z;
  precise vec2 bs = b.xy - factors.shear.xy * b.z;
  precise vec2 cs = c.xy - factors.shear.xy * c.z;
  precise float u = cs.x * bs.y - cs.y * bs.x;
  precise float v = as.x * cs.y - as.y * cs.x;
  precise float w = bs.x * as.y - bs.y * as.x;
  precise float det = u + v + w;
  bool outside = min(min(u, v), w) < 0.0 && max(max(u, v), w) > 0.0;
  vec3 t = vec3(a.z, b.z, c.z) * factors.shear.z;
  return Edges(!outside && det != 0.0, vec3(u, v, w), det, min(min(t.x, t.y), t.z), max(max(t.x, t.y), t.z));
}

// Distance to a triangle's plane, which is better than the one that the edges give: on thin triangles by far, and beside
// the eye of a huge one. Kept between the vertices, because the plane of a triangle seen nearly edge-on tells nothing.
float planeDistance(Ray ray, Edges edges, vec3 normal, float offset) {
  precise float slope = dot(normal, ray.direction);
  precise float t = (offset - dot(normal, ray.origin)) / slope;
  if (slope == 0.0) t = edges.tNear;
  return clamp(t, edges.tNear, edges.tFar);
}
