// What --price puts in the place of refracted: Snell's law in float, for vectors that it takes to be unit.
bool refracted(const vec3 direction, const vec3 N, const vec2 etaRatio, out vec3 T) {
  float dN = dot(direction, N);
  float cos2T = etaRatio.x * etaRatio.x - (1.0 - dN * dN);
  T = direction;
  if (cos2T <= 0.0) return false;
  T = normalize(direction - (dN + sqrt(cos2T)) * N);
  return true;
}
