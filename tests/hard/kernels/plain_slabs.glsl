// What --price puts in the place of enterBox: the interval as it comes out of its rounding.
float enterBox(const vec3 near, const vec3 far, const float tMax) {
  float enter = greater(greater(near.x, near.y), greater(near.z, 0.0));
  float leave = lesser(lesser(far.x, far.y), lesser(far.z, tMax));
  return enter <= leave ? enter : kNoHit;
}
