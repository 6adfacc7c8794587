// From a pixel and a cell of its grid to the direction of an eye ray. The eye is the origin.

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
  uvec2 size = uvec2(frame.width, frame.height);
  // Pixels from the centre of the picture: the whole part is a multiple of 1/2, so that it and the fraction are exact.
  vec2 whole = 0.5 * vec2(ivec2(2u * pixel) - ivec2(size));
  vec2 part = vec2(fraction) * (1.0 / 16777216.0);
  vec2 x, y;
  x.x = twoSum(whole.x, part.x, x.y);
  y.x = twoSum(whole.y, part.y, y.y);

  vec3 centreHi = frame.centreHi, centreLo = frame.centreLo;
  vec3 rightHi = frame.rightHi, rightLo = frame.rightLo;
  vec3 downHi = frame.downHi, downLo = frame.downLo;
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
