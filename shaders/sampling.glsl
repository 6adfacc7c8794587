// Where in its pixel a sample lies: hashes, and the samplers grid, jitter and sobol. In integers, so that the position
// is the same in every renderer.

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

// Hash of one word, "lowbias32" of Wellons' search (nullprogram.com/blog/2018/07/31).
uint hash1(uint x) {
  x = (x ^ (x >> 16u)) * 0x7feb352du;
  x = (x ^ (x >> 15u)) * 0x846ca68bu;
  return x ^ (x >> 16u);
}

// Takes the lowest digit of a number and puts it, shuffled, behind those of the inverse. The shuffle is drawn anew for
// each sequence of digits before it, of which `node` is the number: nested scrambling (Owen, "Randomly permuted
// (t,m,s)-nets and (t,s)-sequences", 1995) by a random linear function of the digit (Owen, "Variance with alternative
// scramblings of digital nets", ACM TOMACS 13(4), 2003).
void moveDigit(const uint radix, const uint seed, inout uint number, inout uint node, inout uint inverse) {
  uint digit = number % radix;
  uint random = hash1(seed + node * 0x9e3779b9u);
  uint add = ((random >> 16u) * radix) >> 16u, factor = 1u + (((random & 0xffffu) * (radix - 1u)) >> 16u);
  inverse = inverse * radix + (factor * digit + add) % radix;
  number /= radix;
  node = node * radix + digit;
}

// A number below n with its digits in reversed order, shuffled: the radical inverse, scrambled. The digits are those of
// the prime factors of n.
uint scrambledInverse(uint number, const uint seed) {
  uint node = 1u, inverse = 0u;
  if (RADICES_LOW > 0u) moveDigit(RADICES_LOW & 255u, seed, number, node, inverse);
  if (RADICES_LOW >> 8u > 0u) moveDigit((RADICES_LOW >> 8u) & 255u, seed, number, node, inverse);
  if (RADICES_LOW >> 16u > 0u) moveDigit((RADICES_LOW >> 16u) & 255u, seed, number, node, inverse);
  if (RADICES_LOW >> 24u > 0u) moveDigit(RADICES_LOW >> 24u, seed, number, node, inverse);
  if (RADICES_HIGH > 0u) moveDigit(RADICES_HIGH & 255u, seed, number, node, inverse);
  if (RADICES_HIGH >> 8u > 0u) moveDigit((RADICES_HIGH >> 8u) & 255u, seed, number, node, inverse);
  if (RADICES_HIGH >> 16u > 0u) moveDigit((RADICES_HIGH >> 16u) & 255u, seed, number, node, inverse);
  if (RADICES_HIGH >> 24u > 0u) moveDigit(RADICES_HIGH >> 24u, seed, number, node, inverse);
  return inverse;
}

// Where in its pixel a sample lies, in units of 2^-24 pixel: in cell (i, j) of the grid, at its centre, jittered, or
// jittered within one of n strips of the cell. With sobol the strips are dealt out so that the samples of a pixel lie
// in n^2 different columns and n^2 different rows ("multi-jittered", Chiu, Shirley and Wang, Graphics Gems IV, 1994), all
// cells of a row in the same strips (Kensler, "Correlated multi-jittered sampling", Pixar 13-01, 2013), in the order of
// scrambled inverses: for n = 2^k there is then one sample in every box of area 1/n^2 whose sides are powers of two, as
// with the points of Sobol. The integers make it the same position in every renderer. n <= 256 keeps i * 2^24 + u inside
// 32 bits.
uvec2 samplePosition(const uvec2 pixel, const uint sampleIndex) {
  const uint n = SAMPLES;
  uvec2 cell = uvec2(sampleIndex % n, sampleIndex / n);
  uint seed = frame.seed;
  uvec2 offset = uvec2(1u << 23u);
  if (SAMPLER != kGrid) offset = hash4(uvec4(pixel, sampleIndex, seed)).xy >> 8u;
  if (SAMPLER == kSobol) {
    uvec2 seeds = hash4(uvec4(pixel, kStripSeed, seed)).xy;
    uvec2 strip = uvec2(scrambledInverse(cell.y, seeds.x), scrambledInverse(cell.x, seeds.y));
    offset = ((strip << 24u) + offset) / n;
  }
  return ((cell << 24u) + offset) / n;
}
