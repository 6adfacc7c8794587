// Samples are what work is measured in.
#include "command/report/sweep_progress.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/interrupt.h"

namespace turner {
namespace {

// When an estimate is one, when it is a good one, and when it should be shown: seconds.
constexpr double kFirst = 3, kEarly = 10, kLong = 600;

std::string inWords(double seconds) {
  return seconds < 120    ? fmt::format("{:.0f} s", seconds)
         : seconds < 7200 ? fmt::format("{:.0f} min", seconds / 60)
                          : fmt::format("{:.1f} h", seconds / 3600);
}

}  // namespace

void SweepProgress::done(const std::string& renderer, double samples, const std::string& what) {
  throwIfInterrupted();
  const double now = line_.secondsSinceStart();
  Load& load = loads_[renderer];
  load.left -= samples;
  load.samples += samples;
  load.seconds += now - last_;
  last_ = now;
  if (now < kFirst || !line_.isDue()) return;
  const double left = secondsLeft();
  line_.show(fmt::format("{:3.0f} %, {} left: {}", 100 * now / (now + left), inWords(left), what));
  if (!warned_ && now > kEarly && left > kLong) {
    warned_ = true;
    line_.note(fmt::format(
        "note: this takes about {} more; fewer samples (--max-samples) or pixels (--width) take less", inWords(left)));
  }
}

double SweepProgress::secondsLeft() const {
  Load all;
  for (const auto& [name, load] : loads_) {
    all.samples += load.samples;
    all.seconds += load.seconds;
  }
  double left = 0;
  for (const auto& [name, load] : loads_) {
    const Load& speed = load.samples > 0 ? load : all;
    if (speed.samples > 0) left += std::max(load.left, 0.0) * speed.seconds / speed.samples;
  }
  return left;
}

}  // namespace turner
