// Environment variables, mkdir and times of last use; failures are ignored.
#include "base/cache_folder.h"

#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>
#include <vector>

namespace turner {
namespace {

namespace fs = std::filesystem;

std::string absoluteFrom(const char* variable) {
  const char* value = std::getenv(variable);
  return value && value[0] == '/' ? value : "";
}

}  // namespace

std::string cacheFolder() {
  const std::string cache = absoluteFrom("XDG_CACHE_HOME");
  if (!cache.empty()) return cache + "/turner";
  const std::string home = absoluteFrom("HOME");
  return home.empty() ? "" : home + "/.cache/turner";
}

void makeCacheFolder(const std::string& folder) {
  // No more than two levels: a home that does not exist is not Turner's to make. The mode is what XDG asks for.
  (void)::mkdir(fs::path(folder).parent_path().c_str(), 0700);
  (void)::mkdir(folder.c_str(), 0700);
}

void dropOldest(const std::string& folder, const std::function<bool(const std::string&)>& ours, size_t most) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (!ours(at->path().filename().string())) continue;
    std::error_code gone;  // another process has dropped it
    const fs::file_time_type used = at->last_write_time(gone);
    if (!gone) files.emplace_back(used, at->path());
  }
  if (files.size() <= most) return;
  std::sort(files.begin(), files.end());
  files.resize(files.size() - most);
  for (const auto& [used, path] : files) fs::remove(path, error);
}

}  // namespace turner
