// Cell after cell of the pixel's n x n grid, in a fixed order.
#include "reference/pixel.h"

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace turner::reference {
namespace {

// What an eye ray's direction may err by: the corners of a box of 4 ulp, and of smaller ones inside it, because at the
// rim of a curved mirror the extreme lies between the corners; then places all over the box (the additive recurrence
// of Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018, in three dimensions).
constexpr double kMostDirectionError = 4 * 0x1p-24;
dvec3 directionError(int k) {
  if (k < 8 * 4) {
    const double size = std::ldexp(kMostDirectionError, -(k >> 3));
    return {k & 1 ? size : -size, k & 2 ? size : -size, k & 4 ? size : -size};
  }
  constexpr double kRoot = 1.2207440846057596;  // of x^4 = x + 1
  const dvec3 step(1 / kRoot, 1 / (kRoot * kRoot), 1 / (kRoot * kRoot * kRoot));
  return kMostDirectionError * (2.0 * glm::fract(double(k) * step) - 1.0);
}

}  // namespace

dvec3 pixelColor(Whitted& whitted, const ImagePlane& plane, const RenderSettings& settings, int x, int y) {
  const int n = settings.samples;
  dvec3 sum(0), lost(0);  // Kahan's compensated sum
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const dvec3 d = plane.directionThrough(samplePosition(x, y, i, j, settings));
      const dvec3 term = whitted.eyeRadiance(d) - lost;
      const dvec3 next = sum + term;
      lost = (next - sum) - term;
      sum = next;
    }
  return sum / double(n * n);
}

PixelBounds pixelBounds(Whitted& whitted, const ImagePlane& plane, const RenderSettings& settings, int x, int y,
                        int rays) {
  const int n = settings.samples;
  PixelBounds sum;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const dvec3 d = plane.directionThrough(samplePosition(x, y, i, j, settings));
      dvec3 least = whitted.eyeRadiance(d), most = least;
      for (int k = 0; k + 1 < rays; ++k) {
        const dvec3 color = whitted.eyeRadiance(glm::normalize(d + directionError(k)));
        least = glm::min(least, color);
        most = glm::max(most, color);
      }
      sum.least += least;
      sum.most += most;
    }
  return {sum.least / double(n * n), sum.most / double(n * n)};
}

}  // namespace turner::reference
