// Files appear whole or not at all.
#pragma once

#include <string>
#include <string_view>

namespace turner {

// Looks, before the work is done, whether `path` can be written later: throws InputError when its folder is missing or
// not writable, or when the path is a folder.
void checkWritable(const std::string& path);

// Writes a file by way of a temporary one beside it, then renames: readers see the old file or the new one, and a
// failure leaves the old one and no temporary. Follows symbolic links; devices and pipes are written directly.
// Throws RunError naming the path and the system's reason (disk full, ...).
void writeWholeFile(const std::string& path, std::string_view bytes);

}  // namespace turner
