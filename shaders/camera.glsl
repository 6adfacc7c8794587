// From a pixel and a cell of its grid to the direction of an eye ray. The eye is the origin.

// The hash of Jarzynski and Olano (JCGT 9(3), 2020), "pcg4d".
uvec4 hash4(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  v ^= v >> 16u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  return v;
}

// Where in its pixel a sample lies, in units of 2^-24 pixel: cell (i, j) of the grid, at its centre or jittered. The
// integers make it the same position in every renderer. n <= 256 keeps i * 2^24 + u inside 32 bits.
uvec2 samplePosition(const uvec2 pixel, const uint sampleIndex) {
  const uint n = SAMPLES;
  uvec2 cell = uvec2(sampleIndex % n, sampleIndex / n);
  uvec2 offset = uvec2(1u << 23u);
  if (JITTER) offset = hash4(uvec4(pixel, sampleIndex, frame.rightLo.w)).xy >> 8u;
  return ((cell << 24u) + offset) / n;
}

// One component of centre + x * right + y * down, each factor a sum of two floats, as a sum of two floats.
float planeComponent(const float centreHi, const float centreLo, const vec2 x, const float rightHi, const float rightLo,
                     const vec2 y, const float downHi, const float downLo, out float rest) {
  float xRest, yRest, sumRest, restA, restB;
  float xProduct = twoProduct(x.x, rightHi, xRest);
  float yProduct = twoProduct(y.x, downHi, yRest);
  precise float small = centreLo + (xRest + (x.x * rightLo + x.y * rightHi)) + (yRest + (y.x * downLo + y.y * downHi));
  float sum = twoSum(xProduct, yProduct, restA);
  sum = twoSum(centreHi, sum, restB);
  small += restA + restB;
  sum = twoSum(sum, small, sumRest);
  rest = sumRest;
  return sum;
}

// The unit direction through a sample, each component with the error of about one rounding.
vec3 eyeDirection(const uvec2 pixel, const uint sampleIndex) {
  uvec2 fraction = samplePosition(pixel, sampleIndex);
  uvec2 size = uvec2(frame.centreLo.w, frame.rightHi.w);
  // Pixels from the centre of the picture: the whole part is a multiple of 1/2, so that it and the fraction are exact.
  vec2 whole = 0.5 * vec2(ivec2(2u * pixel) - ivec2(size));
  vec2 part = vec2(fraction) * (1.0 / 16777216.0);
  vec2 x, y;
  x.x = twoSum(whole.x, part.x, x.y);
  y.x = twoSum(whole.y, part.y, y.y);

  vec3 centreHi = xyz(frame.centreHi), centreLo = xyz(frame.centreLo);
  vec3 rightHi = xyz(frame.rightHi), rightLo = xyz(frame.rightLo);
  vec3 downHi = xyz(frame.downHi), downLo = xyz(frame.downLo);
  vec3 d, rest;
  d.x = planeComponent(centreHi.x, centreLo.x, x, rightHi.x, rightLo.x, y, downHi.x, downLo.x, rest.x);
  d.y = planeComponent(centreHi.y, centreLo.y, x, rightHi.y, rightLo.y, y, downHi.y, downLo.y, rest.y);
  d.z = planeComponent(centreHi.z, centreLo.z, x, rightHi.z, rightLo.z, y, downHi.z, downLo.z, rest.z);

  // The error of 1/length is common to all components: it does not turn the ray.
  float inverse = 1.0 / sqrt(dot(d, d));
  vec3 unit, productRest;
  unit.x = twoProduct(d.x, inverse, productRest.x);
  unit.y = twoProduct(d.y, inverse, productRest.y);
  unit.z = twoProduct(d.z, inverse, productRest.z);
  return unit + (productRest + rest * inverse);
}
