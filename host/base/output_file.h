// Files appear whole or not at all.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace turner {

// The name "-" is standard output, and in messages <stdout>. (A file of this name is ./-)
std::string nameOfOutput(const std::string& path);
// The descriptor that a name stands for which was open at the start, such as "-" and /dev/fd/63: it is written into.
std::optional<int> openOutput(const std::string& path);

// Looks, before the work is done, whether `path` can be written later: throws InputError when its folder is missing or
// not writable, or when the path is a folder.
void checkWritable(const std::string& path);

// Writes a file by way of a temporary one beside it, then renames: readers see the old file or the new one, and a
// failure leaves the old one and no temporary. Follows symbolic links; devices, pipes and
// open descriptors are written directly. The old file's mode and, where possible, owner and group stay.
// Throws RunError naming the path and the system's reason (disk full, ...).
void writeWholeFile(const std::string& path, std::string_view bytes);

}  // namespace turner
