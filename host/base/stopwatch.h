// The host's clock, for how long pieces of work take.
#pragma once

#include <chrono>

namespace turner {

class Stopwatch {
 public:
  // Seconds since the last lap, or since this stopwatch was made; begins the next lap.
  double lap() {
    const double passed = seconds();
    last_ = Clock::now();
    return passed;
  }
  // The same, and the lap goes on.
  double seconds() const { return std::chrono::duration<double>(Clock::now() - last_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace turner
