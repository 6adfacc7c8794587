// Shows how far a work is: one line that renews itself on a terminal, plain lines elsewhere. Writes to stderr.
#pragma once

#include <string>

#include "base/stopwatch.h"
#include "image/settings.h"

namespace turner {

// The line itself.
class StatusLine {
 public:
  // Quiet: shows nothing.
  explicit StatusLine(bool quiet);
  ~StatusLine();  // wipes it from a terminal
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  // Whether it is time for a new text: a terminal can be renewed ten times a second; a log wants a line now and then.
  bool isDue();
  // As much of it as the terminal is wide.
  void show(const std::string& text);
  // A line that stays.
  void note(const std::string& text);

  double secondsSinceStart() const;

 private:
  void wipe();

  bool quiet_, terminal_;
  bool shown_ = false;
  Stopwatch start_, last_;  // since the first and the last text
};

// Of a render.
class ProgressLine {
 public:
  // `what` names the work; `samples` is all of it.
  ProgressLine(std::string what, double samples, bool quiet);

  // Takes the share that is done; also the place where Ctrl-C is noticed (throws Interrupted).
  void operator()(double share);

 private:
  std::string what_;
  double samples_;
  StatusLine line_;
};

}  // namespace turner
