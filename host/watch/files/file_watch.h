// Tells when files may have changed, while their user edits them with any program.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "base/unique_fd.h"

namespace turner::watch {

// What stat() says of a file: differs between two versions of a file unless both were written within one clock tick.
struct FileSignature {
  int error = 0;  // why there is none, 0 where there is one
  uint64_t device = 0, inode = 0;
  uint32_t kind = 0;                                           // regular file, folder, pipe ...
  int64_t size = 0;                                            // this and the times: of regular files only
  int64_t mtime = 0, mtimeNano = 0, ctime = 0, ctimeNano = 0;  // seconds since 1970 and the rest
  bool operator==(const FileSignature&) const = default;
};

// Tells when one of some files may have changed, been replaced, deleted or come back, or when the way to it leads
// elsewhere: a folder replaced, a symbolic link swapped. Opens no file, so a pipe cannot hang it. Throws nothing but
// for want of memory. For one thread.
class FileWatch {
 public:
  // Without inotify (no descriptor left, switched off for a test) it still works, by looking.
  explicit FileWatch(bool useInotify = true);
  FileWatch(const FileWatch&) = delete;
  FileWatch& operator=(const FileWatch&) = delete;

  // Replaces the set of files; they need not exist. Files that stay in the set keep what is known of them, so that no
  // change gets lost. Of a new file later changes are reported: a caller that follows it before reading it
  // misses none.
  void follow(const std::vector<std::string>& files);

  // For poll(): readable when it is worth to look. -1 where there is no inotify.
  int descriptor() const { return inotify_.number; }

  // Those of the files, in order of their names, that changed since they were followed or last reported. Also reported
  // is a file that was open for writing and got closed, even if its signature is the same. Never blocks.
  std::vector<std::string> takeChanges();

  // How long a caller may wait at most before it looks of its own accord.
  int pollMilliseconds() const;

 private:
  struct Followed {
    FileSignature signature;
    std::string target;        // where its path leads, free of links; empty where there is nothing
    bool closedWrite = false;  // since it was last reported
  };

  void drainEvents();
  void renewWatches();

  UniqueFd inotify_;
  std::map<std::string, Followed> files_;
  std::map<int, std::string> watches_;  // inotify's number and the folder
  bool allWatched_ = true;              // every folder that holds a file or a link of the set
};

}  // namespace turner::watch
