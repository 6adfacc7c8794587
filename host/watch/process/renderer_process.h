// The worker as the watcher sees it: a process that is started when there is a job, heard, and ended when it hangs or
// does not give up what is no longer wanted. Times are seconds of the caller's clock.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "watch/plan.h"
#include "watch/process/child.h"
#include "watch/process/messages.h"

namespace turner::watch {

class RendererProcess {
 public:
  explicit RendererProcess(const WatchPlan& plan) : plan_(plan) {}

  // For one that is not busy. Starts a process where there is none; throws RunError where that cannot be.
  void give(Job job, double now);
  // Its answers are no longer wanted, but for that a scene is loaded: with `keepsScene` it may take its time for that.
  void cancel(double now, bool keepsScene);
  // Kills the process.
  void end();

  bool isRunning() const { return process_ != nullptr; }
  bool isBusy() const { return busy_; }
  bool isPreparing() const { return busy_ && purpose_ == Purpose::prepare; }
  Step step() const { return step_; }
  double share() const { return share_; }  // of the step

  // The next answer to the job, if it has come. After the last one, Finished or Refused, it is not busy.
  std::optional<Message> poll(double now);
  // Where a job ended without an answer, because the process died, or was ended here since it hung: what happened.
  std::optional<Refused> takeLoss(double now);

  // Drivers and compilers keep a little of all that they have compiled. Whether that is so much that it is time for a
  // new process; asked once for each version.
  bool hasGrown();

  // For poll(): -1 where there is nothing to wait for.
  int descriptor() const { return process_ && !process_->line().isFinished() ? process_->line().descriptor() : -1; }
  bool hasUnsent() const { return process_ && process_->line().hasRest(); }
  // When takeLoss() has something to decide at the latest.
  double nextDecision() const;
  // The whole program stood still for so long, and the worker too.
  void forgive(double seconds) { lastAdvance_ += seconds; }

 private:
  double limit() const;
  double patience() const;

  const WatchPlan& plan_;
  std::unique_ptr<Child> process_;
  bool busy_ = false;
  uint64_t job_ = 0;  // its number
  Purpose purpose_ = Purpose::prepare;
  Step step_ = Step::open;
  double share_ = 0, lastAdvance_ = 0;
  std::optional<double> cancelledAt_;
  bool keepsScene_ = false;
  double restartSeconds_ = 0;  // that a new process takes to be as far with the scene

  int versions_ = 0;
  size_t settledBytes_ = 0;  // after kSettled of them
};

}  // namespace turner::watch
