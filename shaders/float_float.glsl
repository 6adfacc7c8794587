// Arithmetic where plain float32 is not enough. Knows nothing of rays. `precise` keeps the compiler from contracting or
// re-associating: these formulas live on the rounding of each single operation.

// The lesser and the greater of two numbers, neither of them NaN: min() and max() take care of NaN, which costs lavapipe
// three instructions instead of one.
float lesser(const float a, const float b) { return a < b ? a : b; }
float greater(const float a, const float b) { return a > b ? a : b; }

// The largest of three components.
float largest(const vec3 v) { return max(max(v.x, v.y), v.z); }

const float kRounding = 5.9604645e-8;  // 2^-24, the largest relative error of one operation

// a + b = sum + rest, exactly (Knuth, The Art of Computer Programming 2, 4.2.2).
float twoSum(const float a, const float b, out float rest) {
  precise float sum = a + b;
  precise float bRounded = sum - a;
  precise float aRounded = sum - bRounded;
  precise float restExact = (a - aRounded) + (b - bRounded);
  rest = restExact;
  return sum;
}

vec3 twoSum(const vec3 a, const vec3 b, out vec3 rest) {
  vec3 sum;
  sum.x = twoSum(a.x, b.x, rest.x);
  sum.y = twoSum(a.y, b.y, rest.y);
  sum.z = twoSum(a.z, b.z, rest.z);
  return sum;
}

// a * b = product + rest, exactly (Dekker 1971, split by Veltkamp's constant 2^12 + 1). Not by fma(), which Vulkan lets a
// driver round twice.
float twoProduct(const float a, const float b, out float rest) {
  precise float product = a * b;
  precise float aScaled = 4097.0 * a;
  precise float bScaled = 4097.0 * b;
  precise float aHi = aScaled - (aScaled - a);
  precise float bHi = bScaled - (bScaled - b);
  precise float aLo = a - aHi;
  precise float bLo = b - bHi;
  precise float restExact = ((aHi * bHi - product) + aHi * bLo + aLo * bHi) + aLo * bLo;
  rest = restExact;
  return product;
}

// a.b + (aRest.b + a.bRest) as the sum of two floats, the second a rounding of the first: about twice float's digits
// (Ogita, Rump and Oishi, SIAM J. Sci. Comput. 26(6), 2005, algorithm Dot2).
vec2 wideDot(const vec3 a, const vec3 aRest, const vec3 b, const vec3 bRest) {
  vec3 products, productRests;
  products.x = twoProduct(a.x, b.x, productRests.x);
  products.y = twoProduct(a.y, b.y, productRests.y);
  products.z = twoProduct(a.z, b.z, productRests.z);
  float sumRest0, sumRest1, rest;
  float sum = twoSum(twoSum(products.x, products.y, sumRest0), products.z, sumRest1);
  precise vec3 crosses = aRest * b + a * bRest;
  precise float small = (sumRest0 + sumRest1) + (((productRests.x + productRests.y) + productRests.z) +
                                                 ((crosses.x + crosses.y) + crosses.z));
  sum = twoSum(sum, small, rest);
  return vec2(sum, rest);
}

// Sum and product of two such sums.
vec2 wideSum(const vec2 a, const vec2 b) {
  float sumRest, rest;
  float sum = twoSum(a.x, b.x, sumRest);
  precise float small = sumRest + (a.y + b.y);
  sum = twoSum(sum, small, rest);
  return vec2(sum, rest);
}

vec2 wideProduct(const vec2 a, const vec2 b) {
  float productRest, rest;
  float product = twoProduct(a.x, b.x, productRest);
  precise float small = productRest + (a.x * b.y + a.y * b.x);
  product = twoSum(product, small, rest);
  return vec2(product, rest);
}

// 1 / a likewise.
vec2 wideReciprocal(const float a) {
  float quotient = 1.0 / a, rest;
  float product = twoProduct(quotient, a, rest);
  precise float missing = (1.0 - product) - rest;
  precise float small = missing * quotient;
  return vec2(quotient, small);
}

// Adds a term to a compensated sum (Kahan 1965).
void compensatedAdd(inout vec3 sum, inout vec3 compensation, const vec3 term) {
  precise vec3 corrected = term - compensation;
  precise vec3 next = sum + corrected;
  precise vec3 lost = (next - sum) - corrected;
  compensation = lost;
  sum = next;
}

// ln(1 - q) - k ln 2 for 0 <= q < 1, with a k that brings it near 0, and a small relative error also where q is small.
float logOneMinus(const float q, out int k) {
  // 1 - q = 2^k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)); below 1/4, f = -q without a rounding.
  k = 0;
  float f = -q;
  if (q > 0.25) {
    float m = frexp(1.0 - q, k);
    if (m < 0.70710678) {
      m *= 2.0;
      k -= 1;
    }
    f = m - 1.0;
  }
  // ln(1 + f) = 2 artanh(s) with s = f / (2 + f), |s| <= 0.172: the first term left out is below 5e-11 s.
  float s = f / (2.0 + f);
  float s2 = s * s;
  float series = s2 * (1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0 + s2 * (1.0 / 11.0)))));
  return 2.0 * (s + s * series);
}

// (1 - q)^n for 0 <= q <= 1 and n >= 0, with 0^0 = 1. The built-in pow() is undefined at 0 and loses 1e-5 on lavapipe
// for large n; here what is lost is a few roundings of the logarithm of the result, without the whole powers of two in it.
float powOneMinus(const float q, const float n) {
  if (n == 0.0) return 1.0;
  if (q >= 1.0) return 0.0;
  // (1 - q)^n = 2^(n k) e^(n ln(1 + f)). Of n k the whole part is split off exactly.
  int k;
  float logarithm = logOneMinus(q, k), exponentRest;
  float exponent = twoProduct(n, float(k), exponentRest);
  float whole = floor(exponent + 0.5);
  precise float z = n * logarithm + ((exponent - whole) + exponentRest) * 0.69314718;
  // e^z = 2^more e^z' with |z'| <= ln(2) / 2, ln 2 as the sum of two floats (Cody and Waite 1980).
  float more = floor(z * 1.4426950 + 0.5);
  float y = whole + more;
  if (y < -126.0) return 0.0;
  z = (z - more * 0.69314575) - more * 1.4286068e-6;
  // Taylor's series: the first term left out is below 6e-9.
  float series =
      1.0 + z * (1.0 + z * (1.0 / 2.0 + z * (1.0 / 6.0 + z * (1.0 / 24.0 + z * (1.0 / 120.0 + z * (1.0 / 720.0 + z * (1.0 / 5040.0)))))));
  return series * uintBitsToFloat(uint(int(y) + 127) << 23);
}
