// A table of those that renderers write.
#include "image/primaries.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

namespace turner {
namespace {

constexpr struct {
  const char* name;
  Chromaticities chromaticities;
} kKnown[] = {
    {"Rec. 709", kRec709},
    {"Rec. 2020", {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f}},
    {"Display P3", {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f}},
    {"DCI-P3", {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.314f, 0.351f}},
    {"ACES (AP0)", {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f}},
    {"ACEScg (AP1)", {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f}},
};

}  // namespace

bool areSame(const Chromaticities& a, const Chromaticities& b) {
  constexpr float kTolerance = 1e-3f;
  for (size_t i = 0; i < a.size(); ++i)
    if (!(std::abs(a[i] - b[i]) <= kTolerance)) return false;
  return true;
}

std::string nameOf(const Chromaticities& c) {
  for (const auto& known : kKnown)
    if (areSame(c, known.chromaticities)) return known.name;
  return fmt::format("red ({:.4g}, {:.4g}), green ({:.4g}, {:.4g}), blue ({:.4g}, {:.4g}), white ({:.4g}, {:.4g})",
                     c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7]);
}

}  // namespace turner
