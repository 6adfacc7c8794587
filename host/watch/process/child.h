// A process that works for this one and may crash, hang or be killed without harm. Both are the same program: it is a
// fork, so it has all that this one has in memory.
#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>
#include <string>

#include "watch/process/channel.h"

namespace turner::watch {

class Child {
 public:
  // Forks; `work` runs in the child with its end of the line, and when it returns the child ends. Only for a process
  // without other threads, which a fork would leave in the middle of what they do. The child does not hear Ctrl-C,
  // nor a termination or a hang-up, and dies with this process. Throws RunError.
  explicit Child(const std::function<void(Channel&)>& work);
  ~Child();  // kills it
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  Channel& line() { return *line_; }
  // Stops it and lets it go on: whatever it does lasts longer, no more.
  void pause();
  void goOn();
  // Of its memory, those in RAM; 0 if it has ended.
  size_t residentBytes() const;
  // Kills it, if it has not ended by itself, and says how it ended: "was ended by signal 11 (Segmentation fault)".
  std::string end();

 private:
  pid_t process_ = -1;
  std::unique_ptr<Channel> line_;
  bool paused_ = false;
};

}  // namespace turner::watch
