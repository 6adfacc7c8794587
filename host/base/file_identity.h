// Whether two names are those of one file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace turner {

// Of a file that is there: its device and inode, so that links of both kinds are told. Of one that is not: those of the
// nearest folder that is there, and the rest of the path, so that two names of one new file are told.
struct FileIdentity {
  uint64_t device = 0, inode = 0;
  std::filesystem::path below;
  bool operator==(const FileIdentity&) const = default;
};

// None: nothing in it can be lost, as in a character device or a socket, or it cannot be looked at.
std::optional<FileIdentity> identityOf(const std::string& path);
std::optional<FileIdentity> identityOfOpen(int descriptor);

// As many in a row as Linux follows.
inline constexpr int kMaxLinks = 40;
// Where a symbolic link leads; none: it is no link.
std::optional<std::filesystem::path> linkedFrom(const std::filesystem::path& path);
// Follows symbolic links by hand, because the last one may point to a file that is yet to be made. Stops at what is no
// link; of a ring of links it returns one, and the caller's next call fails with ELOOP.
std::filesystem::path followLinks(const std::string& path);

}  // namespace turner
