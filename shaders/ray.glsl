// A ray, what it finds on its way, and the surface where it ends: what all types of primitives have in common. Ng, t and
// the other symbols are those of docs/light_transport.md.

const float kNoHit = 1e38;  // farther than everything, and still finite when an interval is widened

struct Ray {
  vec3 origin;
  vec3 direction;        // unit for eye and secondary rays; the way to the light for shadow rays
  uint originPrimitive;  // the primitive it starts on, with kStartsInward; kRefNone for an eye ray
};

// A ray from anywhere. From a surface take rayToward() or another of rays.glsl: they know how far off it a ray must start.
Ray ray(const vec3 origin, const vec3 direction) { return Ray(origin, direction, kRefNone); }

bool startsOn(const Ray ray, const uint primitive) { return (ray.originPrimitive & ~kStartsInward) == primitive; }

bool startsInward(const Ray ray) { return (ray.originPrimitive & kStartsInward) != 0u; }

// What a ray's direction gives to all its tests.
struct RayFactors {
  vec3 inverse;     // 1 / direction, for boxes
  uvec3 nearShift;  // where a node's planes that the ray meets first lie: 0 the lower ones, 8 the upper ones
  int axis;         // of the largest component of the direction, for triangles
  vec3 shear;       // Woop's S_x, S_y, S_z
  float norm;       // |direction|, for spheres and cones
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

// Intersection of a ray with a sphere, a cone or a pair of triangles.
struct Intersection {
  float t;            // kNoHit: nothing
  uint primitive;     // itself, or that triangle of the pair
  uint rank;          // its tie-break rank
  bool both;          // the ray passes both triangles, and this is the first: the second is still to be tested
  uint tested;        // primitives that this took, for the counters
  uint interfaceId;   // of a medium: that interface, or 0
  float coincidence;  // how far from t another interface still coincides
};

// Two interfaces coincide if they are no farther apart than 48 roundings of their distance from the eye: that is more
// than how far rays start from a surface, with much room for the errors of both distances, so that these rarely decide.
float coincidenceDistance(const vec3 point, const float errorBound, const float cosine) {
  return max(48.0 * kRounding * length(point), 4.0 * errorBound) / max(abs(cosine), 1.0 / 1024.0);
}

struct Surface {
  vec3 point;
  vec3 Ng, Ns;   // unit, both on the side that the ray came from
  bool front;    // the ray came from the front
  bool outside;  // of a sphere or cone: the ray came from outside, whatever its front is
  float errorBound;  // how far along Ng a ray must start to be on its side for certain
  uint material;
};
