// The user's cache folder: what can be made again and is kept only to save time. Nothing here throws; without a folder
// there is no cache.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace turner {

// $XDG_CACHE_HOME/turner, else $HOME/.cache/turner; only absolute paths count. Empty: there is no cache.
std::string cacheFolder();

// Makes a cache's folder and the one above it, if it can.
void makeCacheFolder(const std::string& folder);

// Deletes those of the folder's files that have not been used for longest, down to `most` of the ones that are `ours`
// by their names.
void dropOldest(const std::string& folder, const std::function<bool(const std::string&)>& ours, size_t most);

}  // namespace turner
