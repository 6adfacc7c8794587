// A ray against one open truncated cone (NFF's c), and the surface there: the points at a distance of radius(s) from an
// axis, s from 0 to its length. It has no ends and two sides; a cylinder is one whose radius is the same everywhere.
//
// Symbols: alpha: half the angle at the tip, 0 for a cylinder; P: the anchor, which is the end of the lesser radius r0;
// a: unit axis from there; x = P + s a + y with y across the axis. The signed distance to the surface is
// cos(alpha)|y| - (base + sin(alpha) s), with base = r0 cos(alpha). The formulas are derived in docs/kernel.md.

// Where the line of a ray meets the whole cone.
struct ConeRoots {
  float foot;       // of the ray, distance from its origin: where it is nearest to the axis, about
  float height;     // of the foot along the axis
  vec3 across;      // from the axis to the foot
  float climb;      // d.a
  vec3 drift;       // d across the axis
  float enter;      // from the foot to where the ray goes in, and out
  float leave;
  bool enters;      // is there such a place, on this half of the double cone
  bool leaves;
  bool goesThrough;  // both are on one half: the ray is inside between them
  float middle;      // from the foot, between both
};

// The foot of a distant or very thin cone: all that cancels with twice the digits. `foot` may be any distance near it.
void distantFoot(const Ray ray, const RayFactors factors, const Cone cone, const float foot, out vec3 across,
                 out float height) {
  vec3 fRest, wayRest, gRest, upRest, sumRest, way, up;
  vec3 f = twoSum(ray.origin, -cone.anchor, fRest);
  way.x = twoProduct(foot, ray.direction.x, wayRest.x);
  way.y = twoProduct(foot, ray.direction.y, wayRest.y);
  way.z = twoProduct(foot, ray.direction.z, wayRest.z);
  vec3 g = twoSum(f, way, gRest);
  precise vec3 allRest = gRest + (fRest + wayRest);
  // Any height near g.a will do: what is left of it in the difference is taken back.
  height = dot(g, cone.axis) + dot(allRest, cone.axis);
  up.x = twoProduct(height, cone.axis.x, upRest.x);
  up.y = twoProduct(height, cone.axis.y, upRest.y);
  up.z = twoProduct(height, cone.axis.z, upRest.z);
  vec3 sum = twoSum(g, -up, sumRest);
  precise vec3 difference = sum + (sumRest + ((allRest - upRest) - height * cone.axisRest));
  float left = dot(difference, cone.axis);
  across = difference - left * cone.axis;
  height += left;
}

ConeRoots coneRoots(const Ray ray, const RayFactors factors, const Cone cone) {
  ConeRoots roots;
  vec3 f = ray.origin - cone.anchor, d = factors.inverseNorm * ray.direction;
  float climb = dot(d, cone.axis), height = dot(f, cone.axis);
  vec3 drift = d - climb * cone.axis, across = f - height * cone.axis;
  if (FAR_CONES && (cone.material & kFarCone) != 0u) {
    // The rounded d and a: both errors count, where the ray is nearly parallel to the axis.
    drift -= climb * cone.axisRest;
    across -= height * cone.axisRest;
  }
  float squaredDrift = dot(drift, drift), along = dot(across, drift);
  float inverse = 1.0 / greater(squaredDrift, 1e-30);
  float foot = -along * inverse;
  // A ray along the axis is near to it far away: not beyond the cone. The anchor's foot on it is at -f.d.
  float middle = -(along + height * climb);
  float nearest = foot;
  foot = lesser(greater(foot, middle - cone.reach), middle + cone.reach);
  bool isNearest = foot == nearest;
  if (FAR_CONES && (cone.material & kFarCone) != 0u) {
    float scaled = foot * factors.inverseNorm;
    distantFoot(ray, factors, cone, scaled, across, height);
    along = dot(across, drift);
    float shift = lesser(greater(-along * inverse, -2.0 * cone.reach), 2.0 * cone.reach);
    across += shift * drift;
    height += shift * climb;
    along = dot(across, drift);
    foot += shift;
  } else {
    across += foot * drift;
    height += foot * climb;
    along += foot * squaredDrift;
  }
  float squaredAcross = dot(across, across);
  roots.foot = foot;
  roots.height = height;
  roots.across = across;
  roots.climb = climb;
  roots.drift = drift;
  // A t^2 + 2 B t + C = 0. With the foot's y across d, B^2 - A C has no terms that cancel:
  // cos^2 (|d_y|^2 radius^2 - A |y|^2). What the foot misses of that, `along`, is in the last term.
  float quadratic = squaredDrift, linear = along, constant = squaredAcross - cone.base * cone.base;
  float discriminant = along * along - squaredDrift * constant;
  if (SLOPED_CONES) {
    float climbing = cone.slope * climb, radius = cone.base + cone.slope * height;  // times the cosine
    quadratic = cone.squaredCosine * squaredDrift - climbing * climbing;
    linear = cone.squaredCosine * along - climbing * radius;
    constant = cone.squaredCosine * squaredAcross - radius * radius;
    discriminant = cone.squaredCosine * (squaredDrift * radius * radius - quadratic * squaredAcross +
                                         along * (cone.squaredCosine * along - 2.0 * climbing * radius));
    if (!isNearest) {
      // Foot independent: |v|^2 - cos^2 |y x d_y|^2, with v = R d_y - kappa y.
      vec3 v = radius * drift - climbing * across, moment = cross(across, drift);
      discriminant = cone.squaredCosine * (dot(v, v) - cone.squaredCosine * dot(moment, moment));
    }
  }
  roots.enters = discriminant >= 0.0;
  roots.leaves = roots.enters;
  roots.goesThrough = true;
  if (SLOPED_CONES) {
    // Steeper than the generators a ray meets each half once; on the wide side of the tip it goes in if it climbs.
    roots.goesThrough = quadratic > 0.0;
    roots.enters = roots.enters && (roots.goesThrough || climb > 0.0);
    roots.leaves = roots.leaves && (roots.goesThrough || climb < 0.0);
    inverse = 1.0 / (abs(quadratic) > 1e-30 ? quadratic : 1e-30);
  }
  // The ray goes in at (-B - root) / A, out at (-B + root) / A, whatever the sign of A: the derivative there is -root,
  // root. Where B / A is beyond the cone, the one that cancels comes from the product of both, C / A.
  float root = sqrt(greater(discriminant, 0.0)), first = -linear - root, second = root - linear;
  bool cancels = abs(linear) > cone.reach * abs(quadratic), falls = linear <= 0.0;
  float farther = falls ? second : first;
  float product = constant / (abs(farther) > 1e-30 ? farther : 1e-30);
  roots.enter = cancels && falls ? product : first * inverse;
  roots.middle = -linear * inverse;
  roots.leave = cancels && !falls ? product : second * inverse;
  return roots;
}

// Whether what the whole cone has at this distance from the foot is between the ends. The bound has room for the
// rounding of the height, so that no light comes through where two cones share a circle, or a cone and a sphere.
bool isBetweenEnds(const Cone cone, const ConeRoots roots, const float t) {
  float height = roots.height + t * roots.climb, margin = 8.0 * kRounding * cone.reach;
  bool within = height >= -margin && height <= cone.span + margin;
  if (STEEP_CONES && cone.slope > 0.70710678) {
    // A cone that is nearly a disc ends at a radius: its height says less about that.
    vec3 y = roots.across + t * roots.drift;
    float cosine = sqrt(cone.squaredCosine), radius = cosine * length(y), steepMargin = margin * cosine;
    within = radius >= cone.base - steepMargin && radius <= cone.base + cone.slope * cone.span + steepMargin &&
             cone.base + cone.slope * height >= -0.5 * margin;
  }
  return within;
}

struct ConeHit {
  float t;           // in units of the ray's direction; kNoHit: nothing
  float fromFoot;    // the same, unit, from the foot
  bool fromOutside;  // the ray goes in
};

// The nearest place where a ray meets a cone. One that starts on it has a root 0, so that the other is twice the middle of
// both. Outward it never comes back: each half of a double cone is convex. The other half is not between the ends.
ConeHit nearestConeHit(const Ray ray, const RayFactors factors, const Cone cone, const ConeRoots roots,
                       const bool startsOnIt) {
  bool inward = startsInward(ray);
  float enter = (roots.foot + roots.enter) * factors.inverseNorm, fromFoot = roots.leave;
  float self = greater(roots.foot + 2.0 * roots.middle, -roots.foot);
  if (SLOPED_CONES) {
    // It starts a margin off, which counts more where the cone is narrower: there is the root that the ray itself has.
    float radius = cone.base + cone.slope * (roots.height - roots.foot * roots.climb);
    float farRadius = cone.base + cone.slope * (roots.height + self * roots.climb);
    if (roots.leaves && roots.leave > -roots.foot && farRadius < 0.5 * radius) self = roots.leave;
  }
  fromFoot = startsOnIt ? self : fromFoot;
  float leave = (roots.foot + fromFoot) * factors.inverseNorm;
  bool enters = roots.enters && !startsOnIt && enter > 0.0 && isBetweenEnds(cone, roots, roots.enter);
  bool leaves = (startsOnIt ? inward && roots.goesThrough : roots.leaves && leave > 0.0) &&
                isBetweenEnds(cone, roots, fromFoot);
  float nearest = enters ? enter : kNoHit;
  bool takesSecond = leaves && leave < nearest;
  return ConeHit(takesSecond ? leave : nearest, takesSecond ? fromFoot : roots.enter, !takesSecond);
}

Intersection intersectCone(const Ray ray, const RayFactors factors, const uint primitive) {
  Cone cone = coneAt(primitive & kRefOffsetMask);
  ConeRoots roots = coneRoots(ray, factors, cone);
  float t = nearestConeHit(ray, factors, cone, roots, startsOn(ray, primitive)).t;
  // It encloses nothing, and so is no medium's interface.
  return Intersection(t, primitive, cone.rank, false, 1u, 0u, 0.0);
}

// How far from its surface a ray must start to be on one side of a cone for certain, by the kernel's arithmetic. The cone
// itself is left exactly, by its root; this is for a sphere or a cone that touches it.
float coneErrorBound(const Cone cone) {
  return 2.0 * kRounding * (largest(abs(cone.anchor)) + 2.0 * cone.reach);
}

// The surface where a ray has hit a cone. Solved once more: only the root itself tells at the silhouette from which side
// the ray came, and from the foot the place has more digits than o + t d.
Surface coneSurface(const Ray ray, const RayFactors factors, const uint primitive) {
  Cone cone = coneAt(primitive & kRefOffsetMask);
  ConeRoots roots = coneRoots(ray, factors, cone);
  ConeHit hit = nearestConeHit(ray, factors, cone, roots, startsOn(ray, primitive));
  vec3 y = roots.across + hit.fromFoot * roots.drift;
  float height = roots.height + hit.fromFoot * roots.climb;
  y -= dot(y, cone.axis) * cone.axis;
  float distance = length(y);
  // At the tip itself the normal is any; this one faces the ray.
  vec3 side = abs(cone.axis.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0);
  vec3 across = dot(roots.drift, roots.drift) > 0.0 ? -roots.drift : cross(cone.axis, side);
  across = distance > 0.0 ? y / distance : normalize(across);
  float cosine = sqrt(cone.squaredCosine);
  vec3 outward = cosine * across - cone.slope * cone.axis;
  // Back on the cone.
  float above = cosine * distance - (cone.base + cone.slope * height);
  Surface surface;
  surface.point = cone.anchor + (height * cone.axis + (y - above * outward));
  surface.outside = hit.fromOutside;
  surface.front = hit.fromOutside != ((cone.material & kConeInward) != 0u);
  surface.Ng = hit.fromOutside ? outward : -outward;
  surface.Ns = surface.Ng;
  surface.errorBound = coneErrorBound(cone);
  surface.material = cone.material & ~(kConeInward | kFarCone);
  return surface;
}
