// The user's cache folder: what can be made again and is kept only to save time. Nothing here throws; without a folder
// there is no cache.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace turner {

// $XDG_CACHE_HOME/turner, else $HOME/.cache/turner; only absolute paths count. Empty: there is no cache.
std::string cacheFolder();

// Makes a cache's folder and the one above it, if it can.
void makeCacheFolder(const std::string& folder);

// The bytes of a regular file; none where it cannot be read. Marks it as used, where that is allowed.
std::optional<std::string> readCached(const std::string& path);
// Puts a file in its place whole, if it can. A temporary one has letters more behind its name.
void writeCached(const std::string& path, std::string_view bytes);

// Cached files are named by a SHA-256 in hex and a suffix; temporary ones of killed processes have letters more behind
// it, or a dot before it. Deletes those of this suffix that have not been used for longest, down to `most`.
void dropOldest(const std::string& folder, std::string_view suffix, size_t most);

}  // namespace turner
