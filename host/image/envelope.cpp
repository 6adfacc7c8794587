// In: a picture, the reference's, and the bounds of the pixels in which they differ. Out: what the bounds excuse.
#include "image/envelope.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "image/compare.h"

namespace turner {
namespace {

// Where the pixel stands in Image::rgb.
size_t offsetOf(const Image& image, const Pixel& pixel) {
  const Window& w = image.window;
  return 3 * (size_t(pixel.y - w.y0) * size_t(w.width()) + size_t(pixel.x - w.x0));
}

// Written so that a NaN is not within.
bool isWithin(const float* rgb, const PixelBounds& bounds, double tolerance) {
  for (int c = 0; c < 3; ++c)
    if (!(rgb[c] >= bounds.least[c] - tolerance && rgb[c] <= bounds.most[c] + tolerance)) return false;
  return true;
}

// The pixels that are not excused, in a row: as a picture, so that the comparer can take its percentiles.
Image remaining(const Image& image, const std::vector<bool>& excused) {
  Image row;
  for (size_t i = 0; i < excused.size(); ++i)
    if (!excused[i]) row.rgb.insert(row.rgb.end(), &image.rgb[3 * i], &image.rgb[3 * i] + 3);
  row.width = int(row.rgb.size() / 3);
  row.height = 1;
  row.window = {0, 0, row.width, row.height};
  return row;
}

}  // namespace

std::vector<Pixel> pixelsApart(const Image& picture, const Image& reference, double tolerance) {
  assert(picture.window == reference.window);
  std::vector<Pixel> apart;
  const Window& w = picture.window;
  for (int y = w.y0; y < w.y1; ++y)
    for (int x = w.x0; x < w.x1; ++x) {
      const float* same = &reference.rgb[offsetOf(reference, {x, y})];
      const glm::dvec3 value(same[0], same[1], same[2]);
      if (!isWithin(&picture.rgb[offsetOf(picture, {x, y})], {value, value}, tolerance)) apart.push_back({x, y});
    }
  return apart;
}

EnvelopeRule applyEnvelope(const Image& picture, const Image& reference, const BoundsOf& boundsOf, double tolerance) {
  const std::vector<Pixel> apart = pixelsApart(picture, reference, tolerance);
  std::vector<bool> excused(picture.window.area());
  std::vector<Pixel> left = apart;
  for (const int rays : {kEnvelopeRays, kDenseEnvelopeRays}) {
    if (left.empty()) break;
    const std::vector<PixelBounds> bounds = boundsOf(left, rays);
    assert(left.size() == bounds.size());
    std::vector<Pixel> outside;
    for (size_t i = 0; i < left.size(); ++i) {
      const size_t offset = offsetOf(picture, left[i]);
      excused[offset / 3] = isWithin(&picture.rgb[offset], bounds[i], tolerance);
      if (!excused[offset / 3]) outside.push_back(left[i]);
    }
    left = std::move(outside);
  }
  EnvelopeRule rule;
  rule.outside = left.size();
  const double pixels = double(picture.window.area());
  rule.needed = double(apart.size()) / pixels;
  rule.excused = double(apart.size() - rule.outside) / pixels;
  const Comparison rest = compareImages(remaining(picture, excused), remaining(reference, excused), tolerance);
  rule.p99 = rest.p99;
  rule.p999 = rest.p999;
  return rule;
}

}  // namespace turner
