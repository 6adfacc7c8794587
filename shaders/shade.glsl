// What happens where a ray meets a surface: docs/light_transport.md, sentence by sentence. V points back along the ray,
// L to a light, N is the shading normal Ns, H the half vector (Blinn 1977).

struct Surface {
  vec3 point;
  vec3 Ng, Ns;   // unit, both on the side that the ray came from
  bool front;    // the ray came from the front
  bool outside;  // of a sphere: the ray came from outside, whatever its front is
  float errorBound;  // how far along Ng a ray must start to be on its side for certain
  uint material;
};

// A material as it lies in memory.
struct MaterialData {
  Row diffuse, specular, other;
};

MaterialData materialData(const uint material) {
  uint row = kMaterialRows * material;
  return MaterialData(ROW(materials, row + kMaterialDiffuse), ROW(materials, row + kMaterialSpecular),
                      ROW(materials, row + kMaterialOther));
}

float reflectance(const MaterialData m) { return uintBitsToFloat(m.diffuse.w); }     // r
float transmittance(const MaterialData m) { return uintBitsToFloat(m.specular.w); }  // t
float shininess(const MaterialData m) { return uintBitsToFloat(m.other.x); }         // n
float indexOfRefraction(const MaterialData m) { return uintBitsToFloat(m.other.y); }  // eta
float localWeight(const MaterialData m) { return uintBitsToFloat(m.other.z); }

// Turns the hit of a ray into the surface there.
Surface surfaceAt(const Ray ray, const RayFactors factors, const float t, const uint primitive) {
  Surface surface;
  uint row = kUnitRows * (primitive & kRefOffsetMask);
  vec3 V = -ray.direction;
  surface.errorBound = 0.0;
  surface.outside = true;
  Row row0 = ROW(primitives, row), row1 = ROW(primitives, row + 1u);
  if (SPHERES && !isOfTriangles(primitive)) {
    SphereData sphere = sphereOf(row0, row1);
    // By where the ray starts, not by its angle: at the silhouette that is within its rounding.
    bool startsOnIt = (ray.originPrimitive & ~kStartsInward) == primitive;
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
    surface.material = row1.y & ~kNearEye;
  }
  if (TRIANGLES && isOfTriangles(primitive)) {
    uint isSecond = (primitive & kRefSecond) != 0u ? 1u : 0u;
    Row plane = ROW(primitives, row + kPairNormals + isSecond);
    surface.Ng = xyz(plane);
    surface.material = row1.w;
    // Put the point back on the plane, as far as it can be rounded to it.
    vec3 point = ray.origin + t * ray.direction;
    float offset = uintBitsToFloat(plane.w);
    surface.point = point - surface.Ng * wideSum(wideDot(surface.Ng, vec3(0), point, vec3(0)), vec2(-offset, 0)).x;
    surface.errorBound = planeErrorBound(surface.Ng, offset, surface.point);
    surface.Ns = surface.Ng;
    Row row2 = ROW(primitives, row + kPairV2), row3 = ROW(primitives, row + kPairV3);
    if (SMOOTH_NORMALS && row2.w != kRefNone) {
      vec3 a = sheared(ray, factors, xyz(isSecond != 0u ? row3 : row0));
      vec3 b = sheared(ray, factors, xyz(isSecond != 0u ? row2 : row1));
      vec3 c = sheared(ray, factors, xyz(isSecond != 0u ? row1 : row2));
      precise vec3 areas = vec3(edgeArea(b, c), edgeArea(c, a), edgeArea(a, b));
      precise float det = areas.x + areas.y + areas.z;
      vec3 weights = areas / det;
      uint normals = kVertexNormalsRows * (row2.w + isSecond);
      vec3 Ns = weights.x * xyz(ROW(vertexNormals, normals)) + weights.y * xyz(ROW(vertexNormals, normals + 1u)) +
                weights.z * xyz(ROW(vertexNormals, normals + 2u));
      float squared = dot(Ns, Ns);
      if (squared > 0.0) surface.Ns = Ns * inversesqrt(squared);
      if (dot(surface.Ng, surface.Ns) < 0.0) surface.Ng = -surface.Ng;
    }
    surface.front = dot(surface.Ng, V) > 0.0;
    if (!surface.front) {
      surface.Ng = -surface.Ng;
      surface.Ns = -surface.Ns;
    }
  }
  if (dot(surface.Ns, V) <= 0.0) surface.Ns = surface.Ng;
  return surface;
}

// A ray from the surface, to the side of Ng (`above`) or through it. It starts as far from the surface as the margin
// says. From a triangle that is by a step along the ray, which stays where it was, as far as it is not too shallow; a
// sphere knows its other root by the ray's start.
Ray leaveSurface(const Surface surface, const uint primitive, const vec3 direction, const bool above) {
  vec3 away = above ? surface.Ng : -surface.Ng;
  float cosine = max(dot(direction, away), 1e-6), step = surface.errorBound * min(1.0 / cosine, 16.0);
  if (!isOfTriangles(primitive)) step = 0.0;
  vec3 origin = surface.point + step * direction + (surface.errorBound - step * cosine) * away;
  bool inward = above != surface.outside;
  return Ray(origin, direction, primitive | (inward ? kStartsInward : 0u));
}

// A ray to a light. The light's end stays where it is.
Ray leaveToLight(const Surface surface, const uint primitive, const vec3 lightPosition) {
  Ray ray = leaveSurface(surface, primitive, vec3(0), true);
  ray.direction = lightPosition - ray.origin;
  return ray;
}

// Whether a light stands above both the surface and its shading normal, so that a shadow ray is worth its time.
bool facesLight(const Surface surface, const vec3 lightPosition) {
  vec3 L = lightPosition - surface.point;
  return dot(surface.Ns, L) > 0.0 && dot(surface.Ng, L) > 0.0;
}

// Whether a surface sends nothing of any light toward the eye by itself.
bool reflectsNoLight(const MaterialData material) {
  vec3 most = max(xyz(material.diffuse), HIGHLIGHTS ? xyz(material.specular) : vec3(0));
  return localWeight(material) * largest(most) <= 0.0;
}

// E (k_d + k_s max(0, N.H)^n) N.L of one light that is not in shadow.
vec3 lightReflected(const Surface surface, const vec3 V, const Row lightPosition, vec3 E, const MaterialData material) {
  vec3 toward = xyz(lightPosition) - surface.point;
  // Scaled first: the square of a distance of 1e-23 would be 0.
  vec3 L = toward / largest(abs(toward));
  L /= sqrt(dot(L, L));
  // Nearer than 1e-15 the light falls off no further, so that the picture stays finite.
  if (FALLOFF && lightPosition.w != 0u) E /= max(dot(toward, toward), 1e-30);
  vec3 brdf = xyz(material.diffuse);
  if (HIGHLIGHTS) {
    vec3 H = L + V;
    float h2 = dot(H, H);
    // N.H = 1 - |N - H|^2 / 2 for unit vectors: near 1, where a high power looks, the difference keeps its digits.
    vec3 difference = surface.Ns - H * inversesqrt(max(h2, 1e-30));
    float q = 0.5 * dot(difference, difference);
    if (h2 > 0.0) brdf += xyz(material.specular) * powOneMinus(min(q, 1.0), shininess(material));
  }
  return E * brdf * dot(surface.Ns, L);
}

// The direction mirrored about a normal on the side of V.
vec3 mirrored(const vec3 direction, const vec3 N) { return direction - 2.0 * dot(direction, N) * N; }

// R: about Ns, or about Ng where that would lead below the surface.
vec3 reflection(const Surface surface, const vec3 direction) {
  vec3 R = mirrored(direction, surface.Ns);
  return dot(R, surface.Ng) > 0.0 ? R : mirrored(direction, surface.Ng);
}

// The index of refraction behind a surface over that before it, where nothing else is made of glass there.
vec2 indexBehind(const Surface surface, const float eta) { return surface.front ? vec2(eta, 0) : wideReciprocal(eta); }

// Snell's law in vector form; false on total internal reflection. n: index of refraction on the other side over that on
// the side of V. Near the critical angle the cosine is a small difference, of digits that N and the direction have: so
// the decision and cosT are computed with twice the digits, from vectors that are unit but for their rounding.
bool refracted(const vec3 direction, const vec3 N, const vec2 n, out vec3 T) {
  const vec3 none = vec3(0);
  vec2 dd = wideDot(direction, none, direction, none), NN = wideDot(N, none, N, none), dN = wideDot(direction, none, N, none);
  // All times dd NN: sin^2 of the angle of incidence, n^2 times cos^2 of that of refraction.
  vec2 one = wideProduct(dd, NN), sin2I = wideSum(one, -wideProduct(dN, dN));
  float cos2T = wideSum(wideProduct(wideProduct(n, n), one), -sin2I).x;
  T = direction;
  if (cos2T <= 0.0) return false;
  T = normalize(direction - (dN.x + sqrt(cos2T)) * N);
  return true;
}

// T: about Ns, or about Ng where that would not lead through the surface; false on total internal reflection.
bool transmission(const Surface surface, const vec3 direction, const vec2 n, out vec3 T) {
  bool passes = refracted(direction, surface.Ns, n, T);
  if (passes && dot(T, surface.Ng) >= 0.0) passes = refracted(direction, surface.Ng, n, T);
  return passes;
}

// --- glass in glass ---
// What a medium is made of, 0 for air: the row of its material that holds its index of refraction and its glass.
Row mediumOf(const uint medium) {
  Row row = ROW(materials, kMaterialRows * medium + kMaterialOther);
  return medium == 0u ? Row(0u, floatBitsToUint(1.0), 0u, 0u) : row;
}

// A ray's way through all interfaces in one place.
struct Crossing {
  uvec4 beyond;  // the media that it is in behind them
  bool hidden;   // there is the same glass on both sides: no interface is to be seen
  vec2 n;        // index of refraction behind over that before, the sum of two floats
};

// The ray is in `media` and meets `interfaces` on a surface of this material. The sets are what is true: to enter a medium once
// more, or to leave it again, changes nothing. Nothing goes on through an opaque surface.
Crossing crossInterfaces(const uvec4 media, const uvec4 allInterfaces, const MaterialData material, const bool front) {
  uvec4 interfaces = transmittance(material) > 0.0 ? allInterfaces : uvec4(0u), beyond = media;
  uint i = 0u;
  do {
    uint interfaceId = idAt(interfaces, i);
    if (interfaceId != 0u && (interfaceId & kInterfaceFront) == 0u) beyond = without(beyond, interfaceId);
    ++i;
  } while (i < kMaxInterfaces && idAt(interfaces, i) != 0u);
  i = 0u;
  do {
    uint interfaceId = idAt(interfaces, i), medium = interfaceId & ~kInterfaceFront;
    // At a thin edge a ray may meet both sides of a medium at once: in the end it is out.
    if ((interfaceId & kInterfaceFront) != 0u && !has(interfaces, medium)) beyond = withMedium(beyond, medium);
    ++i;
  } while (i < kMaxInterfaces && idAt(interfaces, i) != 0u);

  Row before = mediumOf(activeMedium(media)), behind = mediumOf(activeMedium(beyond));
  bool isMedium = material.other.w != 0u;
  // What is no medium that matters: glass on its back, on its front whatever is there.
  if (!isMedium) {
    before.y = front ? before.y : material.other.y;
    behind.y = front ? material.other.y : behind.y;
  }
  vec2 n = wideProduct(vec2(uintBitsToFloat(behind.y), 0), wideReciprocal(uintBitsToFloat(before.y)));
  return Crossing(beyond, isMedium && before.w == behind.w, n);
}
