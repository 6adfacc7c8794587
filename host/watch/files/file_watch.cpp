// In: names of files. Out: which of them changed. inotify says when to look, stat() says what changed; that way no
// event has to be understood, and lost ones only cost time.
//
// Folders are watched, not files, because most editors replace a file rather than write to it.
#include "watch/files/file_watch.h"

#include <limits.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <set>
#include <utility>

namespace turner::watch {
namespace {

// As many links on one way as the kernel follows.
constexpr int kMaxLinks = 40;
// Rounds of walking and watching while somebody moves folders about; after that the next look goes on.
constexpr int kMaxRounds = 8;
// Reads of events in one look, so that a busy folder cannot hold it up; the rest keeps the descriptor readable.
constexpr int kMaxReads = 64;
// A safety net where inotify works: network file systems do not report what other machines write.
constexpr int kPollWatched = 1000;
constexpr int kPollUnwatched = 250;

// For every folder on the way to a file: it went away or moved. These do not fire for what is in it, so that a busy
// /tmp or /home further up wakes nobody.
constexpr uint32_t kFolderItself = IN_DELETE_SELF | IN_MOVE_SELF;
// For folders that hold a file or a link, or lack it: also names that come and go, writing that ends, and times and
// rights. Not IN_MODIFY, which would wake the caller for half-written files; its price is that a file whose time of
// change alone is set by name, without opening it, is only found at the next look.
constexpr uint32_t kFolderEntries =
    kFolderItself | IN_CLOSE_WRITE | IN_CREATE | IN_DELETE | IN_MOVED_FROM | IN_MOVED_TO | IN_ATTRIB;

// Folders, by paths free of links, and what to watch for in them.
using Folders = std::map<std::string, uint32_t>;

FileSignature signatureOf(const std::string& path) {
  FileSignature seen;
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0) {
    seen.error = errno;
    return seen;
  }
  seen.device = found.st_dev;
  seen.inode = found.st_ino;
  seen.kind = found.st_mode & S_IFMT;
  // A terminal's times change with every line printed to it, a folder's with every file in it: neither is news.
  if (!S_ISREG(found.st_mode)) return seen;
  seen.size = found.st_size;
  seen.mtime = found.st_mtim.tv_sec;
  seen.mtimeNano = found.st_mtim.tv_nsec;
  seen.ctime = found.st_ctim.tv_sec;
  seen.ctimeNano = found.st_ctim.tv_nsec;
  return seen;
}

std::string join(const std::string& folder, const std::string& name) {
  return folder == "/" ? folder + name : folder + "/" + name;
}

std::string parentOf(const std::string& folder) {
  const size_t slash = folder.rfind('/');
  return slash == 0 || slash == std::string::npos ? "/" : folder.substr(0, slash);
}

// Puts the names in a path on a stack, the first on top.
void pushNames(const std::string& path, std::vector<std::string>& names) {
  size_t end = path.size();
  while (end > 0) {
    const size_t slash = path.rfind('/', end - 1);
    const size_t begin = slash == std::string::npos ? 0 : slash + 1;
    if (end > begin) names.push_back(path.substr(begin, end - begin));
    end = slash == std::string::npos ? 0 : slash;
  }
}

// The absolute path, with its links; empty where there is none.
std::string absolutePath(const std::string& path) {
  if (path.empty() || path.size() >= PATH_MAX) return "";
  if (path[0] == '/') return path;
  char here[PATH_MAX];
  // A working folder out of reach has a name that does not begin with '/'.
  if (!::getcwd(here, sizeof here) || here[0] != '/') return "";
  return join(here, path);
}

// Walks the way to a file as the kernel does, name by name, and notes the folders whose changes would lead it
// elsewhere. Returns the path of the file free of links, or nothing where the way ends early.
std::string walkTo(const std::string& file, Folders& folders) {
  std::vector<std::string> names;
  pushNames(absolutePath(file), names);
  std::string folder = "/";
  int links = 0;
  while (!names.empty()) {
    const std::string name = std::move(names.back());
    names.pop_back();
    if (name == ".") continue;
    if (name == "..") {
      folder = parentOf(folder);
      continue;
    }
    const std::string path = join(folder, name);
    struct stat found {};
    if (::lstat(path.c_str(), &found) != 0) {
      // What is missing may be made here. Watch one folder up too: of a removed folder in which a shell still stands
      // no IN_DELETE_SELF comes, and a folder closed to us is opened by a change that its parent reports.
      folders[folder] |= kFolderEntries;
      folders[parentOf(folder)] |= kFolderEntries;
      return "";
    }
    if (S_ISLNK(found.st_mode)) {
      folders[folder] |= kFolderEntries;
      char target[PATH_MAX];
      const ssize_t length = ::readlink(path.c_str(), target, sizeof target);
      if (length <= 0 || ++links > kMaxLinks) return "";
      if (target[0] == '/') folder.resize(1);  // begins again at the root
      pushNames(std::string(target, size_t(length)), names);
    } else if (S_ISDIR(found.st_mode) && !names.empty()) {
      folders[folder] |= kFolderItself;
      folder = path;
    } else {
      // The file, or what stands in place of a folder.
      folders[folder] |= kFolderEntries;
      return names.empty() ? path : "";
    }
  }
  return "";
}

}  // namespace

FileWatch::FileWatch(bool useInotify) : inotify_(useInotify ? ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC) : -1) {}

void FileWatch::follow(const std::vector<std::string>& files) {
  const std::set<std::string> wanted(files.begin(), files.end());
  bool same = wanted.size() == files_.size();
  for (const std::string& file : wanted) same = same && files_.count(file) != 0;
  if (same) return;

  std::erase_if(files_, [&](const auto& followed) { return wanted.count(followed.first) == 0; });
  std::vector<std::string> added;
  for (const std::string& file : wanted) {
    if (files_.try_emplace(file).second) added.push_back(file);
  }
  // Watch first, look then: a change in between is reported.
  renewWatches();
  for (const std::string& file : added) files_[file].signature = signatureOf(file);
}

std::vector<std::string> FileWatch::takeChanges() {
  drainEvents();
  renewWatches();
  std::vector<std::string> changed;
  for (auto& [file, followed] : files_) {
    const FileSignature now = signatureOf(file);
    if (now == followed.signature && !followed.closedWrite) continue;
    followed.signature = now;
    followed.closedWrite = false;
    changed.push_back(file);
  }
  return changed;
}

int FileWatch::pollMilliseconds() const {
  return inotify_.number >= 0 && allWatched_ ? kPollWatched : kPollUnwatched;
}

// Empties the queue and notes which files were closed after writing. Their times may not show it: file systems' clocks
// tick every few milliseconds, some every second or two. Any other event means no more than: look.
void FileWatch::drainEvents() {
  if (inotify_.number < 0) return;
  std::set<std::string> closed;
  alignas(inotify_event) char events[16384];
  for (int i = 0; i < kMaxReads; ++i) {
    const ssize_t length = ::read(inotify_.number, events, sizeof events);
    if (length < 0 && errno == EINTR) continue;
    if (length <= 0) break;
    for (size_t at = 0; at < size_t(length);) {
      inotify_event event;
      std::memcpy(&event, events + at, sizeof event);
      const auto watch = watches_.find(event.wd);
      if ((event.mask & IN_CLOSE_WRITE) != 0 && event.len > 0 && watch != watches_.end()) {
        closed.insert(join(watch->second, events + at + sizeof event));  // the name ends with a zero
      }
      at += sizeof event + event.len;
    }
  }
  for (auto& [file, followed] : files_) {
    if (closed.count(followed.target) != 0) followed.closedWrite = true;
  }
}

// Watches the folders on the ways as they are now. inotify watches a folder and not its name, so that a folder that was
// replaced gets a new watch here and the old one loses its own.
void FileWatch::renewWatches() {
  if (inotify_.number < 0) return;
  Folders before;
  for (int i = 0; i < kMaxRounds; ++i) {
    Folders folders;
    for (auto& [file, followed] : files_) followed.target = walkTo(file, folders);
    // Who walked the same way before and after the watches were set knows that they are in the right places.
    if (i > 0 && folders == before) return;

    std::map<int, std::string> renewed;
    allWatched_ = true;
    // The same folder may be mounted under two names; the stronger mask comes last and stays.
    for (const uint32_t mask : {kFolderItself, kFolderEntries}) {
      for (const auto& [folder, wanted] : folders) {
        if (wanted != mask) continue;
        const int watch = ::inotify_add_watch(inotify_.number, folder.c_str(), mask | IN_ONLYDIR);
        if (watch >= 0) renewed[watch] = folder;
        // Folders further up are often closed to reading; without them a move is seen a little later.
        else if (mask == kFolderEntries)
          allWatched_ = false;
      }
    }
    for (const auto& [watch, folder] : watches_) {
      // Fails where the kernel has dropped the watch of a deleted folder. Numbers are not used twice.
      if (renewed.count(watch) == 0) ::inotify_rm_watch(inotify_.number, watch);
    }
    watches_ = std::move(renewed);
    before = std::move(folders);
  }
}

}  // namespace turner::watch
