// In: a path and bytes. Out: a file that is there whole, or a failure that leaves everything as it was.
#include "base/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "base/errors.h"
#include "base/unique_fd.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

// As many links in a row as the kernel follows.
constexpr int kMaxLinks = 40;
// Of the target's name that a temporary's name repeats, so that long names still leave room for the rest.
constexpr size_t kNameBytes = 150;
// Attempts at a name for the temporary that nobody else uses.
constexpr int kMaxAttempts = 100;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError(path + ": error: " + why);
}

[[noreturn]] void fail(const std::string& path, const char* call, int error) {
  throw RunError(path + ": error: cannot write: " + call + ": " + std::strerror(error));
}

// A temporary file that goes away unless it was renamed.
struct Temporary {
  std::string path;
  explicit Temporary(std::string made) : path(std::move(made)) {}
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  ~Temporary() {
    if (!path.empty()) ::unlink(path.c_str());
  }
};

// Follows symbolic links by hand, because the last one may point to a file that is yet to be made. Stops at what is no
// link; of a ring of links it returns one, and the caller's next call fails with ELOOP.
fs::path followLinks(const std::string& path) {
  fs::path target = path;
  for (int i = 0; i < kMaxLinks; ++i) {
    std::error_code error;
    const fs::path next = fs::read_symlink(target, error);
    if (error) return target;
    target = target.parent_path() / next;  // an absolute `next` replaces all of it
  }
  return target;
}

fs::path folderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// Closing may be the moment at which a network file system reports that its disk is full.
void closeFile(const std::string& path, UniqueFd& file) {
  // After EINTR Linux has closed the file all the same.
  if (::close(std::exchange(file.number, -1)) != 0 && errno != EINTR) fail(path, "close", errno);
}

// Writes to what cannot be replaced by a rename: a device or a pipe.
void writeInto(const std::string& path, std::string_view bytes) {
  UniqueFd file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (file.number < 0) fail(path, "open", errno);
  if (!writeAll(file.number, bytes)) fail(path, "write", errno);
  closeFile(path, file);
}

// Makes a new file beside `target` and returns its path, its descriptor in `number`.
std::string makeTemporary(const std::string& path, const fs::path& target, int& number) {
  const std::string stem =
      "." + target.filename().string().substr(0, kNameBytes) + ".turner-" + std::to_string(getpid());
  for (int i = 0; i < kMaxAttempts; ++i) {
    const std::string name = (folderOf(target) / (i == 0 ? stem : stem + "-" + std::to_string(i))).string();
    number = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (number >= 0) return name;
    if (errno != EEXIST) break;
  }
  fail(path, "open", errno);
}

}  // namespace

void checkWritable(const std::string& path) {
  if (path.empty()) throw InputError("the name of an output file is empty; name a file, such as picture.exr");

  // Look at what is there.
  struct stat found {};
  if (::stat(path.c_str(), &found) == 0) {
    if (S_ISDIR(found.st_mode))
      refuse(path, "is a folder; name a file in it, such as " + (fs::path(path) / "picture.exr").string());
    if (::access(path.c_str(), W_OK) != 0) refuse(path, std::string("cannot be written: ") + std::strerror(errno));
    if (!S_ISREG(found.st_mode)) return;
  } else if (errno == ENAMETOOLONG) {
    refuse(path, "the name is too long; choose a shorter one");
  } else if (errno == ELOOP) {
    refuse(path, "is a symbolic link that leads back to itself; name another file");
  }
  if (path.back() == '/') refuse(path, "ends with '/', so it names no file; add a file name");

  // Look at the folder in which the file will appear.
  const fs::path target = followLinks(path);
  const std::string folder = folderOf(target).string();
  if (::stat(folder.c_str(), &found) != 0) {
    const int error = errno;
    if (error == ENOENT) refuse(path, "the folder " + folder + " does not exist; make it first");
    if (error == ENOTDIR) refuse(path, folder + " is not in a folder; a part of the path is a file");
    refuse(path, "cannot look at the folder " + folder + ": " + std::strerror(error));
  }
  if (!S_ISDIR(found.st_mode)) refuse(path, folder + " is not a folder; name a file in a folder");
  // The superuser may write everywhere but on a read-only file system; access() knows.
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    refuse(path, "the folder " + folder + " is not writable (" + std::strerror(errno) + "); choose another one");
  }
}

bool writeAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(size_t(written));
  }
  return true;
}

void writeWholeFile(const std::string& path, std::string_view bytes) {
  struct stat found {};
  if (::stat(path.c_str(), &found) == 0 && !S_ISREG(found.st_mode)) return writeInto(path, bytes);

  const fs::path target = followLinks(path);
  int number = -1;
  Temporary temporary(makeTemporary(path, target, number));
  UniqueFd file(number);
  if (!writeAll(file.number, bytes)) fail(path, "write", errno);
  // Bring the bytes to the disk before the name: else a power cut may leave an empty file under the new name.
  if (::fsync(file.number) != 0) fail(path, "fsync", errno);
  closeFile(path, file);
  if (::rename(temporary.path.c_str(), target.c_str()) != 0) fail(path, "rename", errno);
  temporary.path.clear();
}

}  // namespace turner
