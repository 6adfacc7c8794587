// The picture of the reference, rendered once for a scene by a process of its own while nothing else works.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "image/image.h"
#include "watch/plan.h"
#include "watch/process/child.h"

namespace turner::watch {

class ReferenceProcess {
 public:
  explicit ReferenceProcess(const WatchPlan& plan) : plan_(plan) {}

  // Works on the scene of this epoch, unless that is done; what belongs to another is dropped. Throws RunError.
  void work(uint64_t sceneEpoch);
  // Stands still: who is measured now shall have the machine.
  void pause();
  void end();

  // Of the scene of this epoch, if it is done.
  const Image* image(uint64_t sceneEpoch) const;
  // Whether the picture has come, or why there is none; once.
  bool poll(std::string& fault);

  // For poll(): -1 where there is nothing to wait for.
  int descriptor() const { return process_ && !paused_ ? process_->line().descriptor() : -1; }

 private:
  const WatchPlan& plan_;
  std::unique_ptr<Child> process_;
  bool paused_ = false;
  uint64_t epoch_ = 0;  // of the image, or of the work
  std::optional<Image> image_;
};

}  // namespace turner::watch
