// Two hash functions and a scrambled radical inverse make the positions; the camera makes directions of them.
#include "reference/samples.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace turner::reference {
namespace {

using glm::dvec2;

// pcg4d: Jarzynski and Olano, "Hash functions for GPU rendering", JCGT 9(3), 2020.
std::array<uint32_t, 2> hash(uint32_t x, uint32_t y, uint32_t z, uint32_t w) {
  const auto mix = [&] {
    x += y * w;
    y += z * x;
    z += x * y;
    w += y * z;
  };
  for (uint32_t* word : {&x, &y, &z, &w}) *word = *word * 1664525u + 1013904223u;
  mix();
  for (uint32_t* word : {&x, &y, &z, &w}) *word ^= *word >> 16;
  mix();
  return {x, y};
}

// "lowbias32", a hash of one word by C. Wellons (nullprogram.com/blog/2018/07/31).
uint32_t hash(uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352d;
  x ^= x >> 15;
  x *= 0x846ca68b;
  return x ^ (x >> 16);
}

// The radical inverse of a number below n, nested scrambling applied to its digits (Owen 1995, 2003): the last digit of
// the number becomes the first, and what shuffles it hangs on the digits that came before, of which `node` is the code.
// Digits are those of the prime factors of n, the smallest last.
uint32_t scrambledInverse(uint32_t number, uint32_t n, uint32_t seed, uint32_t node) {
  if (n == 1) return 0;
  uint32_t prime = 2;
  while (n % prime != 0) ++prime;
  const uint32_t digit = number % prime, rest = n / prime;
  const uint32_t random = hash(seed + node * 0x9e3779b9u);
  const uint32_t shift = (random >> 16) * prime / 65536, factor = 1 + (random & 65535) * (prime - 1) / 65536;
  const uint32_t shuffled = (digit * factor + shift) % prime;
  return shuffled * rest + scrambledInverse(number / prime, rest, seed, node * prime + digit);
}

}  // namespace

dvec2 samplePosition(int x, int y, int i, int j, const RenderSettings& settings) {
  const uint32_t n = uint32_t(settings.samples);
  // Where in the cell: a fraction of `parts`.
  uint64_t u = 1u << 23, v = 1u << 23, parts = 1u << 24;
  if (settings.sampler != Sampler::grid) {
    const auto words = hash(uint32_t(x), uint32_t(y), uint32_t(j) * n + uint32_t(i), settings.seed);
    u = words[0] >> 8;
    v = words[1] >> 8;
  }
  if (settings.sampler == Sampler::sobol) {
    constexpr uint32_t kBeyondAllCells = 65536;
    const auto seeds = hash(uint32_t(x), uint32_t(y), kBeyondAllCells, settings.seed);
    u += uint64_t(scrambledInverse(uint32_t(j), n, seeds[0], 1)) << 24;
    v += uint64_t(scrambledInverse(uint32_t(i), n, seeds[1], 1)) << 24;
    parts *= n;
  }
  // The position counts in 2^-24 of a pixel.
  const uint64_t across = (uint64_t(i) * parts + u) / (parts >> 24) / n;
  const uint64_t down = (uint64_t(j) * parts + v) / (parts >> 24) / n;
  return {x + double(across) * 0x1p-24, y + double(down) * 0x1p-24};
}

ImagePlane::ImagePlane(const Camera& camera, const RenderSettings& settings)
    : width(settings.width), height(settings.height) {
  const double halfHeight = std::tan(0.5 * glm::radians(camera.fov));
  forward = glm::normalize(camera.target - camera.eye);
  const dvec3 side = glm::normalize(glm::cross(forward, camera.up));
  right = halfHeight * side;
  up = halfHeight * glm::cross(side, forward);
}

dvec3 ImagePlane::directionThrough(const dvec2& position) const {
  return glm::normalize(forward + (2 * position.x - width) / height * right + (height - 2 * position.y) / height * up);
}

}  // namespace turner::reference
