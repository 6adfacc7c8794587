// Reads whole files and names their contents.
#pragma once

#include <string>
#include <string_view>

namespace turner {

// As messages have it: "-" and /dev/stdin are <stdin> (a file of the name "-" is ./-), /dev/fd/63, which a shell makes
// of
// <(...), is <descriptor 63>; any other name stands for itself. The first two are in no folder.
std::string nameOfInput(const std::string& path);
// Whether it may be read once only: "-", an open descriptor, a pipe, a terminal.
bool isStream(const std::string& path);

// All bytes of a file, or of a pipe up to its end. Throws InputError naming the path and the system's reason, and
// Interrupted while it waits for a pipe.
std::string readTextFile(const std::string& path);
// The same, for a file that another file names or that is read again: at a pipe, for which one would have to wait, it
// throws InputError too. The first only looks.
void refusePipe(const std::string& path);
// From here on readTextFile() does so too: in a process that nobody could ask to stop waiting.
void refusePipes();
std::string readRegularFile(const std::string& path);

// ".json" of "a/Scene.JSON": what tells a file's kind, in lower case; empty where there is none.
std::string lowerExtension(const std::string& path);

// SHA-256 in hex, as sha256sum prints it.
std::string sha256Hex(std::string_view bytes);

}  // namespace turner
