// The time limits of each step, and when a process is given up.
#include "watch/process/renderer_process.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "watch/process/worker.h"

namespace turner::watch {
namespace {

// Seconds. A worker that was asked to give up gets this long, or as long as a new one needs to be as far with the
// scene.
constexpr double kPatience = 0.3, kMostPatience = 10;
// Compilers, glslang and the driver's, and the opening of a device may take longer than a piece of the picture.
constexpr double kCompilers = 60;
constexpr double kNever = 1e18;
// Of a worker's memory since its kSettled-th version, when its pipelines were all there. lavapipe 22.3 keeps 0.2 MB of
// each kernel.
constexpr double kMostGrowth = 1.02;
constexpr int kSettled = 8;

}  // namespace

void RendererProcess::give(Job job, double now) {
  if (!process_) {
    process_ = std::make_unique<Child>([&plan = plan_](Channel& line) { workForWatcher(line, plan); });
    versions_ = 0;
  }
  job.number = ++job_;
  busy_ = true;
  purpose_ = job.purpose;
  cancelledAt_.reset();
  step_ = Step::open;
  share_ = 0;
  lastAdvance_ = now;
  post(process_->line(), job);
}

void RendererProcess::cancel(double now, bool keepsScene) {
  if (!busy_) return;
  keepsScene_ = keepsScene;
  if (cancelledAt_) return;
  cancelledAt_ = now;
  post(process_->line(), Cancel{job_});
}

void RendererProcess::end() {
  process_.reset();
  busy_ = false;
}

std::optional<Message> RendererProcess::poll(double now) {
  if (!process_) return std::nullopt;
  process_->line().sendRest();
  while (std::optional<Message> message = process_->line().receive()) {
    if (jobOf(*message) != job_) continue;
    if (message->kind == Advance::kind) {
      const Advance advance = decode<Advance>(*message);
      if (advance.step != step_ || advance.share > share_) lastAdvance_ = now;
      step_ = advance.step;
      share_ = advance.share;
      continue;
    }
    lastAdvance_ = now;
    if (message->kind == SceneReady::kind) {
      const SceneReady ready = decode<SceneReady>(*message);
      restartSeconds_ = std::max(restartSeconds_, ready.openSeconds + ready.loadSeconds + ready.buildSeconds);
    }
    if (message->kind == Finished::kind || message->kind == Refused::kind) busy_ = false;
    // A worker whose device may be lost ends by itself.
    if (message->kind == Refused::kind && decode<Refused>(*message).broken) end();
    if (!cancelledAt_ || message->kind == SceneReady::kind) return message;
    if (!process_) break;
  }
  return std::nullopt;
}

double RendererProcess::limit() const {
  return runsKernel(step_) ? plan_.timeout : step_ == Step::scene ? kNever : std::max(kCompilers, plan_.timeout);
}

double RendererProcess::patience() const {
  return keepsScene_ && step_ == Step::scene ? kNever : std::clamp(restartSeconds_, kPatience, kMostPatience);
}

double RendererProcess::nextDecision() const {
  if (!busy_) return kNever;
  return cancelledAt_ ? *cancelledAt_ + patience() : lastAdvance_ + limit();
}

std::optional<Refused> RendererProcess::takeLoss(double now) {
  if (!process_) return std::nullopt;
  const bool died = process_->line().isFinished();
  if (!died && now < nextDecision()) return std::nullopt;
  // It may be this process that was late, and what the worker said waits.
  if (!died && process_->line().hasArrivals()) return std::nullopt;
  const bool isTold = busy_ && !cancelledAt_ && purpose_ != Purpose::prepare;
  Refused loss;
  loss.step = step_;
  loss.hung = !died;
  if (died)
    loss.text = fmt::format("the renderer {} while {}", process_->end(), stepWords(step_));
  else if (runsKernel(step_))
    loss.text = fmt::format("no piece of the work ended within {:g} s (--timeout)", limit());
  else
    loss.text = fmt::format("{} took more than {:g} s", stepWords(step_), limit());
  end();
  if (!isTold) return std::nullopt;
  return loss;
}

bool RendererProcess::hasGrown() {
  if (!process_) return false;
  const size_t bytes = process_->residentBytes();
  if (++versions_ == kSettled) settledBytes_ = bytes;
  return versions_ > kSettled && double(bytes) > kMostGrowth * double(settledBytes_);
}

}  // namespace turner::watch
