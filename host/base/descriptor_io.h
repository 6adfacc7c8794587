// Open files, pipes and terminals: read and written without a wait that a signal could not end.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace turner {

// The name of standard input among inputs, of standard output among outputs.
inline constexpr std::string_view kStandardStream = "-";

// The open descriptor that a name stands for: 1 for /dev/stdout, 63 for /dev/fd/63 (a shell's >(...)), links to them
// included. None: the name is another file's.
std::optional<int> descriptorNamed(const std::string& path);

// Waits until a read (POLLIN) or a write (POLLOUT) will not wait, or fails. Throws Interrupted.
void awaitReady(int file, short events);

// Opens what is there to read. Of a FIFO the first read waits for its writer. -1: errno says why not.
int openToRead(const std::string& path);
// Opens what is there to write into it; waits for the reader of a FIFO. -1: errno says why not. Throws Interrupted.
int openToWrite(const std::string& path);

// Reads at most `most` bytes, 0 at the end; -1: errno says why not. Throws Interrupted while it waits for a pipe.
ssize_t readSome(int file, char* bytes, size_t most);
// Writes all bytes. False: errno says why not. Throws Interrupted while it waits for a pipe.
bool writeAll(int file, std::string_view bytes);

}  // namespace turner
