// poll() with a short time before each call that could wait: a signal may come between a look at its flag and the call,
// or be delivered to another thread.
#include "base/descriptor_io.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <filesystem>

#include "base/file_identity.h"
#include "base/interrupt.h"
#include "base/number.h"

namespace turner {
namespace {

namespace fs = std::filesystem;

constexpr int kGlance = 50;  // milliseconds between looks at the flag

bool isAgain(int error) {
  return error == EINTR || error == EAGAIN || error == EWOULDBLOCK;
}

// Linux makes links of these.
std::optional<int> descriptorSpelt(const std::string& path) {
  if (path == "/dev/stdin") return STDIN_FILENO;
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  for (const std::string folder : {"/dev/fd/", "/proc/self/fd/"}) {
    long long number = 0;
    if (path.starts_with(folder) && parseInteger(path.substr(folder.size()), number) == NumberFault::none &&
        number >= 0 && number <= INT_MAX)
      return int(number);
  }
  return std::nullopt;
}

}  // namespace

std::optional<int> descriptorNamed(const std::string& path) {
  fs::path at = path;
  for (int i = 0; i < kMaxLinks; ++i) {
    if (const std::optional<int> found = descriptorSpelt(at.lexically_normal().string())) return found;
    const std::optional<fs::path> next = linkedFrom(at);
    if (!next) return std::nullopt;
    at = *next;
  }
  return std::nullopt;
}

void awaitReady(int file, short events) {
  pollfd wait{file, events, 0};
  while (::poll(&wait, 1, kGlance) <= 0) throwIfInterrupted();
}

int openToRead(const std::string& path) {
  return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
}

int openToWrite(const std::string& path) {
  for (;;) {
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK);
    struct stat found {};
    if (file >= 0 || errno != ENXIO) return file;
    // ENXIO: nobody reads from it yet; of a socket or a missing device, nobody will.
    if (::stat(path.c_str(), &found) != 0 || !S_ISFIFO(found.st_mode)) return errno = ENXIO, -1;
    throwIfInterrupted();
    ::poll(nullptr, 0, kGlance);
  }
}

ssize_t readSome(int file, char* bytes, size_t most) {
  for (;;) {
    awaitReady(file, POLLIN);
    const ssize_t got = ::read(file, bytes, most);
    if (got >= 0 || !isAgain(errno)) return got;
  }
}

bool writeAll(int file, std::string_view bytes) {
  struct stat found {};
  const bool mayWait = ::fstat(file, &found) != 0 || !S_ISREG(found.st_mode);
  while (!bytes.empty()) {
    if (mayWait) awaitReady(file, POLLOUT);
    // A pipe that is ready has room for so much.
    const ssize_t written =
        ::write(file, bytes.data(), mayWait ? std::min<size_t>(bytes.size(), PIPE_BUF) : bytes.size());
    if (written < 0 && !isAgain(errno)) return false;
    if (written > 0) bytes.remove_prefix(size_t(written));
  }
  return true;
}

}  // namespace turner
