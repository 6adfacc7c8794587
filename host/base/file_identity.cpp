// stat() follows links; what it does not find is looked for from the folder upwards.
#include "base/file_identity.h"

#include <sys/stat.h>

namespace turner {
namespace {

namespace fs = std::filesystem;

std::optional<FileIdentity> identityFrom(const struct stat& found) {
  if (S_ISCHR(found.st_mode) || S_ISSOCK(found.st_mode)) return std::nullopt;
  return FileIdentity{uint64_t(found.st_dev), uint64_t(found.st_ino), {}};
}

}  // namespace

std::optional<fs::path> linkedFrom(const fs::path& path) {
  std::error_code error;
  const fs::path next = fs::read_symlink(path, error);
  if (error) return std::nullopt;
  return path.parent_path() / next;  // an absolute `next` replaces all of it
}

fs::path followLinks(const std::string& path) {
  fs::path target = path;
  for (int i = 0; i < kMaxLinks; ++i) {
    const std::optional<fs::path> next = linkedFrom(target);
    if (!next) return target;
    target = *next;
  }
  return target;
}

std::optional<FileIdentity> identityOf(const std::string& path) {
  struct stat found {};
  if (path.empty()) return std::nullopt;
  if (::stat(path.c_str(), &found) == 0) return identityFrom(found);
  std::error_code error;
  fs::path folder = fs::absolute(followLinks(path), error), below;
  while (!error && folder.has_relative_path()) {
    below = below.empty() ? folder.filename() : folder.filename() / below;
    folder = folder.parent_path();
    if (::stat(folder.c_str(), &found) == 0)
      return FileIdentity{uint64_t(found.st_dev), uint64_t(found.st_ino), below.lexically_normal()};
  }
  return std::nullopt;
}

std::optional<FileIdentity> identityOfOpen(int descriptor) {
  struct stat found {};
  if (::fstat(descriptor, &found) != 0) return std::nullopt;
  return identityFrom(found);
}

}  // namespace turner
