// A ray against one sphere or triangle. In: the ray and the primitive's rows. Out: the distance, in units of the
// ray's direction. Ng, t and the other symbols are those of docs/light_transport.md.

const float kNoHit = 1e38;  // farther than everything, and still finite when an interval is widened

struct Ray {
  vec3 origin;
  vec3 direction;  // unit for eye and secondary rays; the way to the light for shadow rays
  uint leaving;    // the primitive it starts on, with kLeavesInward; kRefNone for an eye ray
};

// What a ray's direction gives to all its tests.
struct RayFactors {
  vec3 inverse;     // 1 / direction, for boxes
  uvec3 nearShift;  // where a node's planes that the ray meets first lie: 0 the lower ones, 8 the upper ones
  int axis;         // of the largest component of the direction, for triangles
  vec3 shear;       // Woop's S_x, S_y, S_z
  float norm;            // |direction|, for spheres
  float inverseSquared;  // 1 / |direction|^2
};

// The three components with axis z last, in cyclic order.
vec3 turn(const vec3 v, const int axis) { return axis == 0 ? v.yzx : axis == 1 ? v.zxy : v; }

RayFactors rayFactors(const vec3 direction) {
  RayFactors factors;
  // A component near 0 becomes 1e-18, keeping its sign: 0 * inf would be NaN in a slab that holds the origin on its
  // plane, and Vulkan does not promise infinities. The boxes are padded, so that nothing is missed by it.
  vec3 magnitude = abs(direction);
  vec3 safe = mix(max(magnitude, 1e-18), -max(magnitude, 1e-18), lessThan(direction, vec3(0)));
  factors.inverse = 1.0 / safe;
  factors.nearShift = mix(uvec3(0u), uvec3(8u), lessThan(direction, vec3(0)));
  factors.axis = magnitude.x > magnitude.y ? (magnitude.x > magnitude.z ? 0 : 2) : (magnitude.y > magnitude.z ? 1 : 2);
  vec3 d = turn(direction, factors.axis);
  factors.shear = vec3(d.x / d.z, d.y / d.z, 1.0 / d.z);
  float squared = dot(direction, direction);
  factors.norm = sqrt(squared);
  factors.inverseSquared = 1.0 / squared;
  return factors;
}

// Distance to a sphere, or kNoHit. The discriminant comes from the distance of the centre to the ray, and the smaller
// root from the product of the roots (Haines, Guenther, Akenine-Moeller, Ray Tracing Gems ch. 7).
float hitSphere(const Ray ray, const RayFactors factors, const vec3 center, const float radius, const bool leavesIt) {
  vec3 f = ray.origin - center;
  float b = -dot(f, ray.direction), middle = b * factors.inverseSquared;
  vec3 perpendicular = f + middle * ray.direction;
  float discriminant = radius * radius - dot(perpendicular, perpendicular);
  float c = dot(f, f) - radius * radius;
  // A shadow ray is as long as its light is far: no product of squares.
  float root = factors.norm * sqrt(greater(discriminant, 0.0));
  float q = b >= 0.0 ? b + root : b - root;
  // Where q is 0, so is c, and the ray touches the sphere where it starts.
  float t0 = q == 0.0 ? 0.0 : c / q, t1 = q * factors.inverseSquared;
  float near = lesser(t0, t1), far = greater(t0, t1);
  float t = discriminant < 0.0 ? kNoHit : near > 0.0 ? near : far > 0.0 ? far : kNoHit;
  // A ray that starts on the sphere: one root is exactly 0, the other 2b/a. Outward it never returns, however grazing.
  float second = (ray.leaving & kLeavesInward) != 0u ? greater(2.0 * middle, 0.0) : kNoHit;
  return leavesIt ? second : t;
}

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
float planeDistance(const Ray ray, const vec3 normal, const float offset, const float tNear, const float tFar) {
  precise float slope = dot(normal, ray.direction);
  precise float t = (offset - dot(normal, ray.origin)) / slope;
  if (slope == 0.0) t = tNear;
  return lesser(greater(t, tNear), tFar);
}
