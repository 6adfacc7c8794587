// Written at once and not through stdio: so nothing is left in a buffer, and a failure is that of one text.
#include "base/tell.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "base/descriptor_io.h"
#include "base/errors.h"

namespace turner {
namespace {

int stdoutOfTold = STDOUT_FILENO;

int tellTo(int file, std::string_view text) noexcept {
  try {
    return writeAll(file, text) ? 0 : errno;
  } catch (const Interrupted&) {
    return EINTR;  // nobody takes it, and the work ends
  }
}

}  // namespace

void holdStandardDescriptors() {
  for (const int file : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(file, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest number that is free: this one.
    (void)::open("/dev/null", file == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void leaveStdoutToOutput() {
  stdoutOfTold = STDERR_FILENO;
}

bool isStdoutTold() {
  return stdoutOfTold == STDOUT_FILENO;
}

int tellText(std::string_view text) noexcept {
  return tellTo(stdoutOfTold, text);
}

int tellTextOnStderr(std::string_view text) noexcept {
  return tellTo(STDERR_FILENO, text);
}

void printResult(std::string_view text) {
  if (writeAll(stdoutOfTold, text)) return;
  const std::string name = stdoutOfTold == STDOUT_FILENO ? "<stdout>" : "<stderr>";
  throw RunError(name + ": error: cannot write: " + std::strerror(errno));
}

}  // namespace turner
