// Errors -> places on a scale -> linear RGB.
#include "report/error_colours.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace turner::report {
namespace {

// Errors from 1e-4 to 1, in decades.
constexpr double kDarkest = -4;

// The inverse of what encodePng applies (IEC 61966-2-1).
float linearOf(double srgb) {
  return float(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
}

// viridis (van der Walt and Smith, matplotlib, CC0) at five places: lightness rises evenly, for every kind of colour
// vision and in grey.
constexpr std::array<std::array<double, 3>, 5> kColours = {
    {{0x44, 0x01, 0x54}, {0x3b, 0x52, 0x8b}, {0x21, 0x91, 0x8c}, {0x5e, 0xc9, 0x62}, {0xfd, 0xe7, 0x25}}};

}  // namespace

Image colouredError(const Image& a, const Image& b) {
  Image coloured(a.width, a.height, a.window);
  for (size_t i = 0; i < coloured.rgb.size(); i += 3) {
    double error = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double difference = std::abs(double(a.rgb[i + c]) - double(b.rgb[i + c]));
      if (!(difference <= error)) error = std::isnan(difference) ? HUGE_VAL : difference;
    }
    const double place =
        std::clamp((std::log10(std::max(error, 1e-30)) - kDarkest) / -kDarkest, 0.0, 1.0) * double(kColours.size() - 1);
    const size_t low = std::min(size_t(place), kColours.size() - 2);
    for (size_t c = 0; c < 3; ++c) {
      const double share = place - double(low);
      coloured.rgb[i + c] = linearOf(((1 - share) * kColours[low][c] + share * kColours[low + 1][c]) / 255);
    }
  }
  return coloured;
}

}  // namespace turner::report
