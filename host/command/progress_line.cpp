// The rate is of samples since the start, the time left follows from it.
#include "command/progress_line.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <utility>

#include "base/interrupt.h"
#include "base/tell.h"

namespace turner {
namespace {

// A line that is longer would wrap, and each renewal scroll.
size_t terminalWidth() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1u : 79;
}

}  // namespace

StatusLine::StatusLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO)) {}

StatusLine::~StatusLine() {
  if (shown_ && terminal_) wipe();
}

bool StatusLine::isDue() {
  if (quiet_) return false;
  return last_.seconds() >= (terminal_ ? 0.1 : 2.0);
}

void StatusLine::show(const std::string& text) {
  if (quiet_) return;
  last_.lap();
  shown_ = true;
  // Spaces wipe what a longer line before has left.
  if (terminal_)
    tellOnStderr("\r{:<{}.{}}", text, terminalWidth(), terminalWidth());
  else
    tellOnStderr("{}\n", text);
}

void StatusLine::note(const std::string& text) {
  if (quiet_) return;
  if (terminal_) wipe();
  tellOnStderr("{}\n", text);
}

// What comes next begins where the line began.
void StatusLine::wipe() {
  tellOnStderr("\r{:<{}}\r", "", terminalWidth());
}

double StatusLine::secondsSinceStart() const {
  return start_.seconds();
}

ProgressLine::ProgressLine(std::string what, double samples, bool quiet)
    : what_(std::move(what)), samples_(samples), line_(quiet) {}

void ProgressLine::operator()(double share) {
  throwIfInterrupted();
  if (share <= 0 || !line_.isDue()) return;
  const double elapsed = line_.secondsSinceStart();
  line_.show(fmt::format("{}: {:3.0f} %, {:.3g} Msamples/s, {:.0f} s left", what_, 100 * share,
                         share * samples_ / elapsed * 1e-6, elapsed * (1 - share) / share));
}

}  // namespace turner
