// In: a path and bytes. Out: a file that is there whole, or a failure that leaves everything as it was.
#include "base/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>

#include "base/descriptor_io.h"
#include "base/errors.h"
#include "base/file_identity.h"
#include "base/temporary.h"
#include "base/unique_fd.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw InputError(path + ": error: " + why);
}

[[noreturn]] void fail(const std::string& path, const char* call, int error) {
  throw RunError(path + ": error: cannot write: " + call + ": " + std::strerror(error));
}

fs::path folderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// Writes to what cannot be replaced by a rename: a device, a pipe, a descriptor that this process was started with.
void writeInto(const std::string& path, int file, std::string_view bytes) {
  if (!writeAll(file, bytes)) fail(path, "write", errno);
}

// Closing may be the moment at which a network file system reports that its disk is full; closing a copy is, too, and
// the file stays locked.
void reportWhatClosingWould(const std::string& path, int file) {
  const int copy = ::fcntl(file, F_DUPFD_CLOEXEC, 0);
  // After EINTR Linux has closed it all the same.
  if (copy < 0 || (::close(copy) != 0 && errno != EINTR)) fail(path, "close", errno);
}

// The new file has the rights of the one that it replaces, as far as they can be given; where its group cannot, what
// that group may, only those may who are all.
void takeRightsOf(const struct stat& old, int file) {
  struct stat made {};
  if (::fstat(file, &made) != 0) return;
  mode_t mode = old.st_mode & 07777;
  if (made.st_uid != old.st_uid && ::fchown(file, old.st_uid, old.st_gid) != 0) mode &= ~mode_t(S_ISUID);
  if (::fstat(file, &made) == 0 && made.st_gid != old.st_gid && ::fchown(file, uid_t(-1), old.st_gid) != 0)
    mode = (mode & ~mode_t(S_IRWXG | S_ISGID)) | ((mode & S_IRWXO) << 3);
  (void)::fchmod(file, mode);  // a file system without modes has none to keep
}

}  // namespace

std::string nameOfOutput(const std::string& path) {
  return path == kStandardStream ? "<stdout>" : path;
}

std::optional<int> openOutput(const std::string& path) {
  return path == kStandardStream ? STDOUT_FILENO : descriptorNamed(path);
}

void checkWritable(const std::string& path) {
  if (path.empty()) throw InputError("the name of an output file is empty; name a file, such as picture.exr");

  if (const std::optional<int> open = openOutput(path)) {
    const int flags = ::fcntl(*open, F_GETFL);
    if (flags < 0 || (flags & O_ACCMODE) == O_RDONLY) refuse(nameOfOutput(path), "is not open for writing");
    return;
  }

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

void writeWholeFile(const std::string& path, std::string_view bytes) {
  if (const std::optional<int> open = openOutput(path)) return writeInto(nameOfOutput(path), *open, bytes);
  struct stat found {};
  const bool isThere = ::stat(path.c_str(), &found) == 0;
  if (isThere && !S_ISREG(found.st_mode)) {
    const UniqueFd file(openToWrite(path));
    if (file.number < 0) fail(path, "open", errno);
    return writeInto(path, file.number, bytes);
  }
  try {
    Temporary temporary(followLinks(path), Temporary::Kind::file);
    const int file = temporary.descriptor();
    if (!writeAll(file, bytes)) fail(path, "write", errno);
    if (isThere) takeRightsOf(found, file);
    // Bring the bytes to the disk before the name: else a power cut may leave an empty file under the new name.
    if (::fsync(file) != 0) fail(path, "fsync", errno);
    reportWhatClosingWould(path, file);
    temporary.moveIntoPlace();
  } catch (const std::system_error& error) {
    throw RunError(path + ": error: cannot write: " + error.what());
  }
}

}  // namespace turner
