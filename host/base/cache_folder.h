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

// The bytes of a cached file; none where it cannot be read. Marks it as used, where that is allowed.
std::optional<std::string> readCached(const std::string& path);

// Puts a file in its place whole, if it can: makes its folder and the one above it, and deletes those files of this
// suffix that have not been used for longest, down to `most`. Files are named by a SHA-256 in hex and their suffix.
void keepInCache(const std::string& path, std::string_view suffix, std::string_view bytes, size_t most);

}  // namespace turner
