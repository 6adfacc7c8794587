// flock() tells the living from the dead. Where it does not work, as for folders on a network's disk, nothing is
// deleted.
#include "base/temporary.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/number.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

// Of the target's name that a temporary's name repeats, so that long names still leave room for the rest.
constexpr size_t kNameBytes = 150;
// Attempts at a name that nobody else uses.
constexpr int kMaxAttempts = 100;

[[noreturn]] void fail(const char* call, int error) {
  throw std::system_error(error, std::generic_category(), call);
}

fs::path folderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

std::string stemFor(const fs::path& target) {
  return "." + target.filename().string().substr(0, kNameBytes) + ".turner-";
}

// The process in ".out.exr.turner-1234" or "...-1234-2"; 0: it is no such name.
pid_t processIn(std::string_view name, std::string_view stem) {
  if (!name.starts_with(stem)) return 0;
  name.remove_prefix(stem.size());
  const size_t dash = name.find('-');
  long long process = 0, attempt = 0;
  if (parseInteger(name.substr(0, dash), process) != NumberFault::none || process < 1 || process > INT32_MAX) return 0;
  if (dash != std::string_view::npos && parseInteger(name.substr(dash + 1), attempt) != NumberFault::none) return 0;
  return pid_t(process);
}

// Another one of the same number as this process may have been killed; its lock is gone then.
bool mayBeGone(pid_t process) {
  return process == ::getpid() || (::kill(process, 0) != 0 && errno == ESRCH);
}

int openFor(Temporary::Kind kind, const fs::path& path) {
  const int flags = O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  return ::open(path.c_str(), kind == Temporary::Kind::folder ? flags | O_DIRECTORY : flags);
}

// Deletes it if it is this user's and its process is gone: it is not locked any more.
void removeIfLeft(const fs::path& path, Temporary::Kind kind) {
  const UniqueFd left(openFor(kind, path));
  struct stat found {};
  if (left.number < 0 || ::fstat(left.number, &found) != 0 || found.st_uid != ::geteuid()) return;
  if (kind == Temporary::Kind::file && (!S_ISREG(found.st_mode) || found.st_nlink != 1)) return;
  if (::flock(left.number, LOCK_EX | LOCK_NB) != 0) return;
  std::error_code ignored;  // then it stays
  if (kind == Temporary::Kind::file)
    fs::remove(path, ignored);
  else
    fs::remove_all(path, ignored);
}

void removeLeft(const fs::path& target, Temporary::Kind kind) {
  const std::string stem = stemFor(target);
  std::error_code error;  // a folder that cannot be read is as good as an empty one
  for (fs::directory_iterator at(folderOf(target), error), end; !error && at != end; at.increment(error)) {
    const pid_t process = processIn(at->path().filename().string(), stem);
    if (process > 0 && mayBeGone(process)) removeIfLeft(at->path(), kind);
  }
}

// Locks what was made just now. False: whoever deletes what was left has taken it for such.
bool lockNew(int descriptor) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) return errno != EWOULDBLOCK;  // else: locks do not work here
  struct stat found {};
  return ::fstat(descriptor, &found) == 0 && found.st_nlink > 0;
}

}  // namespace

Temporary::Temporary(fs::path target, Kind kind) : kind_(kind), target_(std::move(target)) {
  removeLeft(target_, kind_);
  const std::string stem = stemFor(target_) + std::to_string(::getpid());
  const bool isFolder = kind_ == Kind::folder;
  for (int i = 0; i < kMaxAttempts; ++i) {
    const fs::path name = folderOf(target_) / (i == 0 ? stem : stem + "-" + std::to_string(i));
    if (isFolder && ::mkdir(name.c_str(), 0777) != 0) {
      if (errno == EEXIST) continue;
      fail("mkdir", errno);
    }
    UniqueFd made(isFolder ? openFor(kind_, name)
                           : ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (made.number < 0 && errno == EEXIST) continue;
    if (made.number < 0) fail("open", errno);
    if (!lockNew(made.number)) continue;
    std::swap(descriptor_.number, made.number);
    path_ = name;
    return;
  }
  fail("open", EEXIST);
}

Temporary::~Temporary() {
  if (path_.empty()) return;
  std::error_code ignored;  // the failure that led here is the one to tell
  fs::remove_all(path_, ignored);
}

void Temporary::moveIntoPlace() {
  if (::rename(path_.c_str(), target_.c_str()) != 0) fail("rename", errno);
  path_.clear();
}

}  // namespace turner
