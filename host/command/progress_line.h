// Shows how far a render is: one line that renews itself on a terminal, plain lines elsewhere. Writes to stderr.
#pragma once

#include <chrono>
#include <string>

#include "picture/settings.h"

namespace turner {

class ProgressLine {
 public:
  // `what` names the work; `samples` is all of it. Quiet: shows nothing.
  ProgressLine(std::string what, double samples, bool quiet);
  ~ProgressLine();  // ends the line on a terminal

  // Names the work anew.
  void rename(const std::string& what) { what_ = what; }

  // Takes the share that is done; also the place where Ctrl-C is noticed (throws Interrupted).
  void operator()(double share);

 private:
  using Clock = std::chrono::steady_clock;
  std::string what_;
  double samples_;
  bool quiet_, terminal_;
  bool shown_ = false;
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace turner
