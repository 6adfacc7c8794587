// Reads whole files and names their contents.
#pragma once

#include <string>
#include <string_view>

namespace turner {

// All bytes of a file. Throws InputError naming the path and the system's reason.
std::string readTextFile(const std::string& path);
// The same, for a file that another file names or that is read again: at a pipe, for which one would have to wait, it
// throws InputError too. The first only looks.
void refusePipe(const std::string& path);
std::string readRegularFile(const std::string& path);

// ".json" of "a/Scene.JSON": what tells a file's kind, in lower case; empty where there is none.
std::string lowerExtension(const std::string& path);

// SHA-256 in hex, as sha256sum prints it.
std::string sha256Hex(std::string_view bytes);

}  // namespace turner
