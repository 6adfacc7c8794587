// A ray against one sphere or triangle. In: the ray and the primitive. Out: the distance, in units of the
// ray's direction. Ng, t and the other symbols are those of docs/light_transport.md.

const float kNoHit = 1e38;  // farther than everything, and still finite when an interval is widened

// Whether a reference is to triangles, not to spheres: to a leaf of pairs, or to one triangle.
bool isOfTriangles(const uint reference) { return TRIANGLES && (!SPHERES || (reference & kRefTriangle) != 0u); }

struct Ray {
  vec3 origin;
  vec3 direction;  // unit for eye and secondary rays; the way to the light for shadow rays
  uint originPrimitive;    // the primitive it starts on, with kStartsInward; kRefNone for an eye ray
};

// What a ray's direction gives to all its tests.
struct RayFactors {
  vec3 inverse;     // 1 / direction, for boxes
  uvec3 nearShift;  // where a node's planes that the ray meets first lie: 0 the lower ones, 8 the upper ones
  int axis;         // of the largest component of the direction, for triangles
  vec3 shear;       // Woop's S_x, S_y, S_z
  float norm;       // |direction|, for spheres
  float inverseNorm;
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
  factors.norm = length(direction);
  factors.inverseNorm = 1.0 / factors.norm;
  return factors;
}

// Decoded sphere. Where the eye is near its surface, the host gives what its center loses to float, and
// the eye's power |center|^2 - radius^2, computed in wider arithmetic: rounded to float, center and radius would no
// longer tell on which side of the surface the eye is.
struct SphereData {
  vec3 center;
  float radius;
  bool nearEye;
  vec3 centerRest;
  vec2 power;  // of the eye, the sum of two floats
};

SphereData sphereOf(const Sphere packed) {
  SphereData sphere = SphereData(packed.center, packed.radius, false, vec3(0), vec2(0));
  if (NEAR_SPHERES && (packed.material & kNearEye) != 0u) {
    NearSphere rest = nearSphereAt(packed.nearSphere);
    sphere.nearEye = true;
    sphere.centerRest = rest.centerRest;
    sphere.power = vec2(packed.eyePower, rest.eyePowerRest);
  }
  return sphere;
}

// The power |p - center|^2 - radius^2 of a point as the sum of two floats: near the surface twice the radius times the
// height above it. With the power of the anchor, which is the eye or else the center, and u = p - anchor,
// w = center - anchor, it is that + u.(u - 2 w).
vec2 powerOf(const SphereData sphere, const vec3 p) {
  vec2 power = sphere.power;
  if (!sphere.nearEye) {
    power.x = -twoProduct(sphere.radius, sphere.radius, power.y);
    power.y = -power.y;
  }
  vec3 uRest, vRest;
  vec3 u = twoSum(p, sphere.nearEye ? vec3(0) : -sphere.center, uRest);
  vec3 v = twoSum(u, sphere.nearEye ? -2.0 * sphere.center : vec3(0), vRest);
  precise vec3 allVRest = (vRest + uRest) - 2.0 * sphere.centerRest;
  vec2 product = wideDot(u, uRest, v, allVRest);
  float rest, normalizedRest;
  float sum = twoSum(power.x, product.x, rest);
  precise float small = rest + (power.y + product.y);
  sum = twoSum(sum, small, normalizedRest);
  return vec2(sum, normalizedRest);
}

// The smallest positive t at which a ray enters or leaves a sphere, or kNoHit. b: distance along the ray to the foot of
// the perpendicular from the center; c: power of the origin; halfChord: between the foot and the surface; norm: of the
// direction, in units of which t counts. One root is q / norm, without cancellation; the other comes from the product of
// the roots (Haines, Guenther, Akenine-Moeller, Ray Tracing Gems ch. 7). From outside, where c > 0, that is the nearer
// one; from inside the roots have different signs.
float nearestRoot(const float b, const float c, const float halfChord, const float norm) {
  float q = b >= 0.0 ? b + halfChord : b - halfChord;
  bool isOther = c > 0.0 || b < 0.0;
  float t = (isOther ? c : q) / (isOther ? q * norm : norm);
  return t > 0.0 ? t : kNoHit;
}

// For rays that start near the surface, where c is the small difference of two squares, and the discriminant is one at
// the horizon: all with twice the digits.
float hitNearSphere(const Ray ray, const RayFactors factors, const SphereData sphere) {
  // A shadow ray is as long as its light is far: scaled by a power of two, its squares stay within float.
  float scale = uintBitsToFloat(0x7f000000u - (floatBitsToUint(factors.norm) & 0x7f800000u));
  vec3 d = scale * ray.direction, gRest;
  vec3 g = twoSum(sphere.center, -ray.origin, gRest);
  gRest += sphere.centerRest;
  vec2 a = wideDot(d, vec3(0), d, vec3(0)), b = wideDot(d, vec3(0), g, gRest), c = powerOf(sphere, ray.origin);
  float discriminant = wideSum(wideProduct(b, b), -wideProduct(a, c)).x;
  float norm = sqrt(a.x);
  float t = scale * nearestRoot(b.x / norm, c.x, sqrt(greater(discriminant, 0.0)) / norm, norm);
  return discriminant < 0.0 ? kNoHit : t;
}

// The perpendicular from the center of a sphere to a ray, o - c + t d with about the t of its foot. Of a sphere that is
// many radii away the sum cancels, so that its terms need twice the digits.
vec3 distantPerpendicular(const Ray ray, const RayFactors factors, const vec3 center, const float t) {
  vec3 fRest, productRest, sumRest, product;
  vec3 f = twoSum(ray.origin, -center, fRest);
  product.x = twoProduct(t, ray.direction.x, productRest.x);
  product.y = twoProduct(t, ray.direction.y, productRest.y);
  product.z = twoProduct(t, ray.direction.z, productRest.z);
  vec3 sum = twoSum(f, product, sumRest);
  precise vec3 perpendicular = sum + (sumRest + (fRest + productRest));
  // The rounding of t has moved the foot along the ray: take back what is not perpendicular.
  vec3 direction = factors.inverseNorm * ray.direction;
  return perpendicular - dot(perpendicular, direction) * direction;
}

// How far from its surface a ray must start to be on one side of a sphere for certain, by the kernel's arithmetic. The
// sphere itself is left exactly, by its root; this is for one that coincides with it.
float sphereErrorBound(const SphereData sphere, const vec3 point) {
  if (NEAR_SPHERES && sphere.nearEye) return 4.0 * kRounding * largest(abs(point));
  return 2.0 * kRounding * (largest(abs(sphere.center)) + abs(sphere.radius));
}

// The same of a plane and its coplanar neighbours: the point is rounded, both planes' N and d are, and so is every term
// of the neighbour's N.x. The errors of the terms add up to seven roundings of the sum of their sizes at the worst.
float planeErrorBound(const vec3 normal, const float offset, const vec3 point) {
  return 2.0 * kRounding * (dot(abs(normal), abs(point)) + abs(offset));
}

// Distance to a sphere, or kNoHit.
float hitSphere(const Ray ray, const RayFactors factors, const SphereData sphere, const bool startsOnIt) {
  vec3 f = ray.origin - sphere.center;
  float b = -dot(f, ray.direction) * factors.inverseNorm, middle = b * factors.inverseNorm;
  // The discriminant from the distance of the center to the ray (ibid.).
  vec3 perpendicular = f + middle * ray.direction;
  if (FAR_SPHERES) perpendicular = distantPerpendicular(ray, factors, sphere.center, middle);
  float squaredRadius = sphere.radius * sphere.radius;
  float discriminant = squaredRadius - dot(perpendicular, perpendicular);
  float c = dot(f, f) - squaredRadius;
  float t = nearestRoot(b, c, sqrt(greater(discriminant, 0.0)), factors.norm);
  if (discriminant < 0.0) t = kNoHit;
  if (NEAR_SPHERES && abs(c) <= 0.5 * squaredRadius && !startsOnIt) t = hitNearSphere(ray, factors, sphere);
  // A ray that starts on the sphere: one root is exactly 0, the other 2b/a. Outward it never returns, however grazing.
  float second = (ray.originPrimitive & kStartsInward) != 0u ? greater(2.0 * middle, 0.0) : kNoHit;
  return startsOnIt ? second : t;
}

// Whether a point that is not on the sphere is outside of it, as hitSphere sees it.
bool isOutside(const SphereData sphere, const vec3 p) {
  if (NEAR_SPHERES) return powerOf(sphere, p).x > 0.0;
  vec3 f = p - sphere.center;
  return dot(f, f) - sphere.radius * sphere.radius > 0.0;
}

// The unit vector from the center of a distant sphere to where a ray hits it. With the perpendicular goes half a chord,
// toward the origin of the ray or away from it: more digits than o + t d has.
vec3 distantOutward(const Ray ray, const RayFactors factors, const SphereData sphere, const bool fromOutside) {
  float foot = -dot(ray.origin - sphere.center, ray.direction) * factors.inverseNorm * factors.inverseNorm;
  vec3 perpendicular = distantPerpendicular(ray, factors, sphere.center, foot);
  float squared = sphere.radius * sphere.radius - dot(perpendicular, perpendicular);
  float halfChord = (fromOutside ? -factors.inverseNorm : factors.inverseNorm) * sqrt(greater(squared, 0.0));
  return normalize(perpendicular + halfChord * ray.direction);
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
