// What the positions of closed_form.h, which both renderers are held to, are good for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "support/closed_form.h"

namespace turner {
namespace {

using closed_form::hashedPositions;
using glm::dvec2;

// How many points lie in each box of an across x down grid over the pixel.
std::vector<int> counts(const std::vector<dvec2>& points, uint32_t across, uint32_t down) {
  std::vector<int> found(size_t(across) * down);
  for (const dvec2& p : points) ++found[size_t(p.y * down) * across + size_t(p.x * across)];
  return found;
}

TEST(Samplers, SobolHasOneSampleInEachCellColumnAndRow) {
  for (uint32_t n = 1; n <= 36; ++n)
    for (uint32_t seed = 0; seed < 3; ++seed) {
      const std::vector<dvec2> points = hashedPositions(Sampler::sobol, n, 17, 4, seed);
      for (const auto& [across, down] : {std::pair(n, n), std::pair(n * n, 1u), std::pair(1u, n * n)})
        EXPECT_EQ(counts(points, across, down), std::vector<int>(n * n, 1)) << n << ": " << across << " x " << down;
    }
}

// A (0, 2k, 2)-net in base 2, as the first 4^k points of Sobol's sequence are one.
TEST(Samplers, SobolOfPowersOfTwoHasOneSampleInEachBoxOfItsArea) {
  for (uint32_t n = 2; n <= 16; n *= 2)
    for (uint32_t across = 1; across <= n * n; across *= 2)
      EXPECT_EQ(counts(hashedPositions(Sampler::sobol, n, 3, 5, 9), across, n * n / across), std::vector<int>(n * n, 1))
          << n << ": " << across << " boxes across";
}

// No place of a pixel is favoured: over many pixels each sample is everywhere in its cell equally often.
TEST(Samplers, SobolIsUniformOverPixels) {
  constexpr uint32_t n = 3, pixels = 9000, parts = 9;
  std::vector<int> across(parts), down(parts);
  for (uint32_t x = 0; x < pixels; ++x) {
    const dvec2 first = hashedPositions(Sampler::sobol, n, x, 0, 1)[4];  // of the cell in the middle
    ++across[size_t((first.x * n - 1) * parts)];
    ++down[size_t((first.y * n - 1) * parts)];
  }
  for (const std::vector<int>& found : {across, down})
    for (const int count : found) EXPECT_NEAR(count, pixels / parts, 5 * std::sqrt(double(pixels) / parts));
}

// The part of the unit square below a straight line, less what the samples say: over random lines, as root mean square.
double edgeError(Sampler sampler, uint32_t n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  double squares = 0;
  constexpr uint32_t trials = 4000;
  for (uint32_t t = 0; t < trials; ++t) {
    const double angle = 2 * M_PI * uniform(random);
    const dvec2 normal(std::cos(angle), std::sin(angle)), through(uniform(random), uniform(random));
    const double reach = glm::dot(normal, through);
    double inside = 0;
    for (const dvec2& p : hashedPositions(sampler, n, t, 7, 3)) inside += glm::dot(normal, p) < reach;
    // Exact: the corner triangles that the line cuts off.
    const double a = std::abs(normal.x), b = std::abs(normal.y);
    const double d = reach - std::min(normal.x, 0.0) - std::min(normal.y, 0.0);
    const auto half = [](double v) { return v > 0 ? v * v / 2 : 0; };
    const double area = (half(d) - half(d - a) - half(d - b) + half(d - a - b)) / (a * b);
    squares += (inside / (n * n) - area) * (inside / (n * n) - area);
  }
  return std::sqrt(squares / trials);
}

TEST(Samplers, SobolNeedsFewerSamplesThanJitterAtEdges) {
  // The error falls with the power 3/4 of the samples: 0.846 of the error is worth 0.8 of the samples.
  for (const uint32_t n : {3u, 4u, 6u, 8u, 12u, 16u})
    EXPECT_LT(edgeError(Sampler::sobol, n), 0.846 * edgeError(Sampler::jitter, n)) << n;
  EXPECT_LT(edgeError(Sampler::sobol, 2), 0.87 * edgeError(Sampler::jitter, 2));
  for (const uint32_t n : {5u, 7u, 11u})
    EXPECT_LT(edgeError(Sampler::sobol, n), 0.9 * edgeError(Sampler::jitter, n)) << n;
}

// Smooth shading: the mean of exp(1.3 x + 0.7 y) over the pixel, as root mean square over many pixels.
double smoothError(Sampler sampler, uint32_t n) {
  const double exact = (std::exp(1.3) - 1) / 1.3 * (std::exp(0.7) - 1) / 0.7;
  double squares = 0;
  constexpr uint32_t trials = 2000;
  for (uint32_t t = 0; t < trials; ++t) {
    double sum = 0;
    for (const dvec2& p : hashedPositions(sampler, n, t, 7, 3)) sum += std::exp(1.3 * p.x + 0.7 * p.y);
    squares += (sum / (n * n) - exact) * (sum / (n * n) - exact);
  }
  return std::sqrt(squares / trials);
}

TEST(Samplers, SobolIsBetterThanJitterOnSmoothShading) {
  for (const uint32_t n : {2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 12u, 13u, 14u, 15u, 16u, 24u, 32u})
    EXPECT_LT(smoothError(Sampler::sobol, n), smoothError(Sampler::jitter, n)) << n;
}

}  // namespace
}  // namespace turner
