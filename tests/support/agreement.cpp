#include "support/agreement.h"

#include <fmt/format.h>

#include <algorithm>

#include "image/compare.h"

namespace turner::test {

double badPixels(const Image& turner, const Image& peer) {
  return compareImages(turner, peer, kPixelTolerance).badPixels;
}

std::vector<std::string> disagreements(const TracedPicture& turner, const TracedPicture& peer) {
  std::vector<std::string> found;
  struct Kind {
    const char* name;
    uint64_t RayCounts::*count;
  };
  for (const auto& [name, count] : {Kind{"eye", &RayCounts::eye}, Kind{"reflected", &RayCounts::reflected},
                                    Kind{"refracted", &RayCounts::refracted}, Kind{"shadow", &RayCounts::shadow}}) {
    const uint64_t a = turner.rays.*count, b = peer.rays.*count;
    if (std::max(a, b) < kFewRays) continue;
    const double error = double(std::max(a, b) - std::min(a, b)) / double(std::max(a, b));
    if (error > kMostCountError)
      found.push_back(fmt::format("{} rays: {} against {}, {:.2f} % apart; at most {} % is allowed", name, a, b,
                                  100 * error, 100 * kMostCountError));
  }
  const double bad = badPixels(turner.image, peer.image);
  if (bad > kMostBadPixels)
    found.push_back(fmt::format("{:.2f} % of the pixels differ by more than {}; at most {} % is allowed", 100 * bad,
                                kPixelTolerance, 100 * kMostBadPixels));
  return found;
}

}  // namespace turner::test
