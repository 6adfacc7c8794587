// One process for each scene; a paused one is stopped by a signal.
#include "watch/process/reference_process.h"

#include "watch/process/messages.h"
#include "watch/process/worker.h"

namespace turner::watch {

void ReferenceProcess::work(uint64_t sceneEpoch) {
  if (epoch_ == sceneEpoch) {
    if (process_ && paused_) process_->goOn();
    paused_ = false;
    return;
  }
  process_.reset();
  image_.reset();
  epoch_ = sceneEpoch;
  paused_ = false;
  process_ = std::make_unique<Child>([&plan = plan_](Channel& line) { workForWatcher(line, plan); });
  Job job;
  job.purpose = Purpose::reference;
  post(process_->line(), job);
}

void ReferenceProcess::pause() {
  if (process_) process_->pause();
  paused_ = true;
}

void ReferenceProcess::end() {
  process_.reset();
}

const Image* ReferenceProcess::image(uint64_t sceneEpoch) const {
  return epoch_ == sceneEpoch && image_ ? &*image_ : nullptr;
}

bool ReferenceProcess::poll(std::string& fault) {
  if (!process_) return false;
  while (const std::optional<Message> message = process_->line().receive()) {
    if (message->kind == Picture::kind) image_ = decode<Picture>(*message).image;
    if (message->kind == Refused::kind) fault = decode<Refused>(*message).text;
    if (!image_ && fault.empty()) continue;
    process_.reset();
    return true;
  }
  if (!process_->line().isFinished()) return false;
  fault = "its process " + process_->end();
  process_.reset();
  return true;
}

}  // namespace turner::watch
