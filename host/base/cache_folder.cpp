// Environment variables, mkdir and times of last use; failures are ignored.
#include "base/cache_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <utility>
#include <vector>

#include "base/descriptor_io.h"
#include "base/unique_fd.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMostBytes = 64u << 20;  // of a file; nothing that is kept comes near this

std::string absoluteFrom(const char* variable) {
  const char* value = std::getenv(variable);
  return value && value[0] == '/' ? value : "";
}

void makeFolder(const std::string& folder) {
  // No more than two levels: a home that does not exist is not Turner's to make. The mode is what XDG asks for.
  (void)::mkdir(fs::path(folder).parent_path().c_str(), 0700);
  (void)::mkdir(folder.c_str(), 0700);
}

// Unlike a picture's file this one is not brought to the disk before its name: waiting would cost more than the file
// is worth, and the checksum tells what a power cut has left.
void writeWhole(const std::string& path, std::string_view bytes) {
  std::string temporary = path + ".XXXXXX";
  UniqueFd file(::mkostemp(temporary.data(), O_CLOEXEC));
  if (file.number < 0) return;
  bool whole = writeAll(file.number, bytes);
  // A network's disk may say that it is full only now.
  whole &= ::close(std::exchange(file.number, -1)) == 0;
  if (!whole || ::rename(temporary.c_str(), path.c_str()) != 0) ::unlink(temporary.c_str());
}

void dropOldest(const std::string& folder, std::string_view suffix, size_t most) {
  constexpr size_t kHashSize = 64;
  // Temporary ones of killed processes have letters more behind their names.
  const auto isOurs = [&](const std::string& name) {
    return name.size() >= kHashSize + suffix.size() && name.find_first_not_of("0123456789abcdef") == kHashSize &&
           name.compare(kHashSize, suffix.size(), suffix) == 0;
  };
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (!isOurs(at->path().filename().string())) continue;
    std::error_code gone;  // another process has dropped it
    const fs::file_time_type used = at->last_write_time(gone);
    if (!gone) files.emplace_back(used, at->path());
  }
  if (files.size() <= most) return;
  std::sort(files.begin(), files.end());
  files.resize(files.size() - most);
  for (const auto& [used, path] : files) fs::remove(path, error);
}

}  // namespace

std::string cacheFolder() {
  const std::string cache = absoluteFrom("XDG_CACHE_HOME");
  if (!cache.empty()) return cache + "/turner";
  const std::string home = absoluteFrom("HOME");
  return home.empty() ? "" : home + "/.cache/turner";
}

std::optional<std::string> readCached(const std::string& path) {
  // Not to wait, should somebody have put a pipe there.
  const UniqueFd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat found {};
  if (file.number < 0 || ::fstat(file.number, &found) != 0 || !S_ISREG(found.st_mode)) return std::nullopt;
  if (found.st_size < 0 || uint64_t(found.st_size) > kMostBytes) return std::nullopt;
  std::string bytes(size_t(found.st_size), '\0');
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got = ::read(file.number, bytes.data() + done, bytes.size() - done);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return std::nullopt;
    done += size_t(got);
  }
  (void)::futimens(file.number, nullptr);
  return bytes;
}

void keepInCache(const std::string& path, std::string_view suffix, std::string_view bytes, size_t most) {
  const std::string folder = fs::path(path).parent_path().string();
  makeFolder(folder);
  writeWhole(path, bytes);
  dropOldest(folder, suffix, most);
}

}  // namespace turner
