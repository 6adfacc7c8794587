// Shows how far the sweep is. The time left follows from the speed of each renderer so far.
#pragma once

#include <map>
#include <string>

#include "command/progress_line.h"
#include "report/measure.h"

namespace turner {

class SweepProgress : public report::SweepObserver {
 public:
  explicit SweepProgress(bool quiet) : line_(quiet) {}

  void expect(const std::string& renderer, double samples) override { loads_[renderer].left += samples; }
  // Throws Interrupted after Ctrl-C.
  void done(const std::string& renderer, double samples, const std::string& what) override;

 private:
  struct Load {
    double left = 0;                  // samples
    double samples = 0, seconds = 0;  // done
  };

  double secondsLeft() const;

  StatusLine line_;
  std::map<std::string, Load> loads_;
  double last_ = 0;
  bool warned_ = false;
};

}  // namespace turner
