// In: two pictures of the same windows. Out: how far they differ. Sums run in long double, so that the figures of
// hundreds of millions of values are still exact to more digits than are printed.
#include "image/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <vector>

#include "base/errors.h"

namespace turner {
namespace {

// Keeps the relative error finite where B is black.
constexpr long double kRelativeFloor = 0.01L;

// "512 x 512 pixels", and what is there of them.
std::string describe(const Image& image) {
  const Window& w = image.window;
  std::string text = std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels";
  if (w == Window{0, 0, image.width, image.height}) return text + " (all there)";
  return text + " (there: x " + std::to_string(w.x0) + " to " + std::to_string(w.x1 - 1) + ", y " +
         std::to_string(w.y0) + " to " + std::to_string(w.y1 - 1) + ")";
}

void checkSameWindows(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || !(a.window == b.window)) {
    throw InputError("the pictures cannot be compared: A has " + describe(a) + ", B has " + describe(b));
  }
  assert(a.rgb.size() == 3 * a.window.area() && b.rgb.size() == a.rgb.size());
}

// The nearest rank: the smallest value that at least perMille / 1000 of all values do not exceed. Integers, because
// 0.99 * N may come out a little above a whole number. Reorders the values.
double percentile(std::vector<double>& values, size_t perMille) {
  const size_t rank = (values.size() * perMille + 999) / 1000;
  const auto place = values.begin() + std::ptrdiff_t(rank - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace

Comparison compareImages(const Image& a, const Image& b, double threshold) {
  checkSameWindows(a, b);
  const size_t pixels = a.window.area();
  Comparison result;
  result.width = a.window.width();
  result.height = a.window.height();

  // Sum over the channels of the pixels that are finite in both; note the largest error of each.
  long double sum = 0, sumAbsolute = 0, sumSquares = 0, sumRelative = 0;
  std::vector<double> errors;
  errors.reserve(pixels);
  size_t bad = 0;
  for (size_t i = 0; i < pixels; ++i) {
    const float* pa = &a.rgb[3 * i];
    const float* pb = &b.rgb[3 * i];
    bool nan = false, inf = false;
    for (int c = 0; c < 3; ++c) {
      nan = nan || std::isnan(pa[c]) || std::isnan(pb[c]);
      inf = inf || std::isinf(pa[c]) || std::isinf(pb[c]);
    }
    result.nan += nan;
    result.inf += inf;
    if (nan || inf) {
      ++bad;
      continue;
    }
    double largest = 0;
    for (int c = 0; c < 3; ++c) {
      const double difference = double(pa[c]) - double(pb[c]);
      const long double square = static_cast<long double>(difference) * difference;
      sum += difference;
      sumAbsolute += std::abs(difference);
      sumSquares += square;
      sumRelative += square / (static_cast<long double>(pb[c]) * pb[c] + kRelativeFloor);
      largest = std::max(largest, std::abs(difference));
    }
    errors.push_back(largest);
    bad += largest > threshold;
  }

  // Turn sums into means.
  if (pixels > 0) result.badPixels = double(bad) / double(pixels);
  if (errors.empty()) return result;
  const long double count = 3 * static_cast<long double>(errors.size());
  result.rmse = double(std::sqrt(sumSquares / count));
  result.relRmse = double(std::sqrt(sumRelative / count));
  result.mae = double(sumAbsolute / count);
  result.meanSigned = double(sum / count);
  result.max = *std::max_element(errors.begin(), errors.end());
  result.p50 = percentile(errors, 500);
  result.p99 = percentile(errors, 990);
  result.p999 = percentile(errors, 999);
  return result;
}

Image errorImage(const Image& a, const Image& b) {
  checkSameWindows(a, b);
  Image error(a.width, a.height, a.window);
  for (size_t i = 0; i < error.rgb.size(); ++i) error.rgb[i] = std::abs(a.rgb[i] - b.rgb[i]);
  return error;
}

std::vector<std::string> brokenBounds(const Comparison& comparison, const ErrorBounds& bounds) {
  std::vector<std::string> broken;
  const auto check = [&](const char* name, double value, double bound) {
    if (bound < 0) return;
    if (comparison.nan > 0 || comparison.inf > 0)
      broken.push_back(fmt::format("{}: there are pixels with NaN or infinity", name));
    else if (!(value <= bound))  // a bound that is NaN does not hold
      broken.push_back(fmt::format("{}: {:g} is more than {:g}", name, value, bound));
  };
  check("--max-rmse", comparison.rmse, bounds.rmse);
  check("--max-error", comparison.max, bounds.max);
  check("--max-bad-pixels", comparison.badPixels, bounds.badPixels);
  return broken;
}

}  // namespace turner
