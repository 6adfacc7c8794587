// A ray against one sphere, and the surface there. In: the ray and the sphere. Out: the distance, in units of the ray's
// direction.

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
  float second = startsInward(ray) ? greater(2.0 * middle, 0.0) : kNoHit;
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

Intersection intersectSphere(const Ray ray, const RayFactors factors, const uint primitive) {
  Sphere packed = sphereAt(primitive);
  bool startsOnIt = startsOn(ray, primitive);
  SphereData sphere = sphereOf(packed);
  float t = hitSphere(ray, factors, sphere, startsOnIt);
  Intersection found = Intersection(t, primitive, packed.rank, false, 1u, 0u, 0.0);
  if (NESTED_DIELECTRICS && found.t < kNoHit) {
    bool outside = !startsOnIt && isOutside(sphere, ray.origin);
    found.interfaceId = interfaceOf(packed.material & ~kNearEye, outside != (sphere.radius < 0.0));
    vec3 point = ray.origin + found.t * ray.direction;
    float cosine = dot(normalize(point - sphere.center), ray.direction);
    found.coincidence = coincidenceDistance(point, sphereErrorBound(sphere, point), cosine);
  }
  return found;
}

// The surface where a ray hits a sphere at t.
Surface sphereSurface(const Ray ray, const RayFactors factors, const float t, const uint primitive) {
  Surface surface;
  Sphere packed = sphereAt(primitive & kRefOffsetMask);
  SphereData sphere = sphereOf(packed);
  // By where the ray starts, not by its angle: at the silhouette that is within its rounding.
  bool startsOnIt = startsOn(ray, primitive);
  surface.outside = !startsOnIt && isOutside(sphere, ray.origin);
  vec3 point = ray.origin + t * ray.direction;
  bool isFar = FAR_SPHERES && !sphere.nearEye;
  vec3 outward = isFar ? distantOutward(ray, factors, sphere, surface.outside) : normalize(point - sphere.center);
  // Put the point back on the sphere: the error of o + t d grows with t.
  surface.point = sphere.center + abs(sphere.radius) * outward;
  if (NEAR_SPHERES && sphere.nearEye) {
    // The center is far away and rounded. Newton's step to where the power is 0 keeps the digits of the point.
    surface.point = point - (0.5 * powerOf(sphere, point).x / abs(sphere.radius)) * outward;
  }
  surface.errorBound = sphereErrorBound(sphere, surface.point);
  surface.front = surface.outside != (sphere.radius < 0.0);
  surface.Ng = surface.outside ? outward : -outward;
  surface.Ns = surface.Ng;
  surface.material = packed.material & ~kNearEye;
  return surface;
}
