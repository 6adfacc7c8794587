// The rate is of samples since the start, the time left follows from it.
#include "command/progress_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

#include "command/interrupt.h"

namespace turner {

ProgressLine::ProgressLine(std::string what, double samples, bool quiet)
    : what_(std::move(what)), samples_(samples), quiet_(quiet), terminal_(isatty(STDERR_FILENO)) {}

ProgressLine::~ProgressLine() {
  if (shown_ && terminal_) std::fputc('\n', stderr);
}

void ProgressLine::operator()(double share) {
  throwIfInterrupted();
  if (quiet_) return;
  const Clock::time_point now = Clock::now();
  // A terminal can be renewed ten times a second; a log wants a line now and then.
  const std::chrono::duration<double> sinceLast = now - last_, elapsed = now - start_;
  if (sinceLast.count() < (terminal_ ? 0.1 : 2.0) || share <= 0) return;
  last_ = now;
  shown_ = true;
  const double rate = share * samples_ / elapsed.count();
  const double left = elapsed.count() * (1 - share) / share;
  const std::string text =
      fmt::format("{}: {:3.0f} %, {:.3g} Msamples/s, {:.0f} s left", what_, 100 * share, rate * 1e-6, left);
  // Spaces wipe what a longer line before has left.
  if (terminal_)
    fmt::print(stderr, "\r{:<90}", text);
  else
    fmt::print(stderr, "{}\n", text);
  std::fflush(stderr);
}

}  // namespace turner
