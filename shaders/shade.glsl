// What happens where a ray meets a surface: docs/light_transport.md, sentence by sentence. V points back along the ray,
// L to a light, N is the shading normal Ns, H the half vector (Blinn 1977).

// A ray from the surface, to the side of Ng (`above`) or through it. It starts as far from the surface as the error
// bound says. From a triangle that is by a step along the ray, which stays where it was, as far as it is not too shallow; a
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
bool facesLight(const Surface surface, const Light light) {
  vec3 L = light.position - surface.point;
  return dot(surface.Ns, L) > 0.0 && dot(surface.Ng, L) > 0.0;
}

// Whether a surface sends nothing of any light toward the eye by itself.
bool reflectsNoLight(const Material material) {
  LACKS(Highlights, !HIGHLIGHTS && material.localWeight * largest(material.specular) > 0.0);
  vec3 most = max(material.diffuse, HIGHLIGHTS ? material.specular : vec3(0));
  return material.localWeight * largest(most) <= 0.0;
}

// E (k_d + k_s max(0, N.H)^n) N.L of one light that is not in shadow.
vec3 lightReflected(const Surface surface, const vec3 V, const Light light, const Material material) {
  vec3 toward = light.position - surface.point, E = light.color;
  LACKS(Highlights, !HIGHLIGHTS && material.localWeight * largest(material.specular) > 0.0);
  LACKS(Falloff, !FALLOFF && light.falloff != 0u);
  // Scaled first: the square of a distance of 1e-23 would be 0.
  vec3 L = toward / largest(abs(toward));
  L /= sqrt(dot(L, L));
  // Nearer than 1e-15 the light falls off no further, so that the picture stays finite.
  if (FALLOFF && light.falloff != 0u) E /= max(dot(toward, toward), 1e-30);
  vec3 brdf = material.diffuse;
  if (HIGHLIGHTS) {
    vec3 H = L + V;
    float h2 = dot(H, H);
    // N.H = 1 - |N - H|^2 / 2 for unit vectors: near 1, where a high power looks, the difference keeps its digits.
    vec3 difference = surface.Ns - H * inversesqrt(max(h2, 1e-30));
    float q = 0.5 * dot(difference, difference);
    if (h2 > 0.0) brdf += material.specular * powOneMinus(min(q, 1.0), material.shininess);
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
vec2 etaBehind(const Surface surface, const float eta) { return surface.front ? vec2(eta, 0) : wideReciprocal(eta); }

// Snell's law in vector form, T = (I - (I.N + sqrt(eta^2 - sin^2 theta_I)) N) / eta with unit I and N, where eta is
// etaRatio: the index of refraction on the other side over that on the side of V. False on total internal reflection.
// Near the critical angle the cosine is a small difference, of digits that N and the direction have: so the decision and
// cosT are computed with twice the digits, from vectors that are unit but for their rounding.
bool refracted(const vec3 direction, const vec3 N, const vec2 etaRatio, out vec3 T) {
  const vec3 none = vec3(0);
  vec2 dd = wideDot(direction, none, direction, none), NN = wideDot(N, none, N, none),
       dN = wideDot(direction, none, N, none);
  // All times dd NN: sin^2 of the angle of incidence, eta^2 times cos^2 of that of refraction.
  vec2 one = wideProduct(dd, NN), sin2I = wideSum(one, -wideProduct(dN, dN));
  float cos2T = wideSum(wideProduct(wideProduct(etaRatio, etaRatio), one), -sin2I).x;
  T = direction;
  if (cos2T <= 0.0) return false;
  T = normalize(direction - (dN.x + sqrt(cos2T)) * N);
  return true;
}

// T: about Ns, or about Ng where that would not lead through the surface; false on total internal reflection.
bool transmission(const Surface surface, const vec3 direction, const vec2 etaRatio, out vec3 T) {
  bool passes = refracted(direction, surface.Ns, etaRatio, T);
  if (passes && dot(T, surface.Ng) >= 0.0) passes = refracted(direction, surface.Ng, etaRatio, T);
  return passes;
}
