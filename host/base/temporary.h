// What is made beside its place and then renamed: it is there whole or not at all.
#pragma once

#include <filesystem>

#include "base/unique_fd.h"

namespace turner {

// A hidden file or folder beside `target`, .TARGET.turner-PID, which goes away unless it was moved into place. It is
// locked as long as its process lives, so that what a killed process has left is told from what is in work.
class Temporary {
 public:
  enum class Kind { file, folder };
  // Deletes what killed processes have left of this kind for this target, then makes a new one; a file is empty and has
  // the mode 0666 less the umask. Throws std::system_error that names the call.
  Temporary(std::filesystem::path target, Kind kind);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return descriptor_.number; }
  // Replaces the target. Throws std::system_error.
  void moveIntoPlace();

 private:
  Kind kind_;
  std::filesystem::path target_, path_;
  UniqueFd descriptor_{-1};
};

}  // namespace turner
