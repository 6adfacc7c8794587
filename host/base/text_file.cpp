// System calls and nettle.
#include "base/text_file.h"

#include <fcntl.h>
#include <nettle/base16.h>
#include <nettle/sha2.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>

#include "base/descriptor_io.h"
#include "base/errors.h"
#include "base/interrupt.h"
#include "base/reserve.h"
#include "base/unique_fd.h"

namespace turner {

namespace {

bool pipesAreRefused = false;

// Descriptors that can be opened by their name are: a regular file is then read from its beginning.
int openInput(const std::string& path) {
  if (path == kStandardStream) return ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0);
  const std::optional<int> open = descriptorNamed(path);
  struct stat found {};
  if (open && ::fstat(*open, &found) == 0 && !S_ISREG(found.st_mode)) return ::fcntl(*open, F_DUPFD_CLOEXEC, 0);
  return openToRead(path);
}

// Such as /dev/zero, which has no end. /dev/null is as good as an empty file.
bool isEndless(int file, const struct stat& status) {
  if (S_ISBLK(status.st_mode)) return true;
  return S_ISCHR(status.st_mode) && status.st_rdev != makedev(1, 3) && !::isatty(file);
}

}  // namespace

std::string nameOfInput(const std::string& path) {
  if (path == kStandardStream) return "<stdin>";
  const std::optional<int> open = descriptorNamed(path);
  if (!open) return path;
  return *open == STDIN_FILENO ? "<stdin>" : "<descriptor " + std::to_string(*open) + ">";
}

bool isStream(const std::string& path) {
  struct stat found {};
  if (path == kStandardStream || descriptorNamed(path)) return true;
  return ::stat(path.c_str(), &found) == 0 && !S_ISREG(found.st_mode) && !S_ISDIR(found.st_mode);
}

std::string readTextFile(const std::string& path) {
  if (pipesAreRefused) refusePipe(path);
  const std::string name = nameOfInput(path);
  const UniqueFd file(openInput(path));
  if (file.number < 0) throw InputError(name + ": error: cannot open: " + std::strerror(errno));
  struct stat status {};
  const bool isKnown = ::fstat(file.number, &status) == 0;
  if (isKnown && S_ISDIR(status.st_mode)) throw InputError(name + ": error: is a folder, not a file");
  if (isKnown && isEndless(file.number, status)) throw InputError(name + ": error: is a device, not a file or a pipe");

  // One byte more than the size, so that one more read tells the end. A pipe has no size, and a file may grow.
  size_t room = isKnown ? size_t(status.st_size) + 1 : 1;
  std::string text;
  for (size_t got = 0;; room = 2 * room + (size_t(1) << 16)) {
    text.reserve(room);
    prefault(text.data() + got, room - got);
    text.resize(room);
    while (got < room) {
      const ssize_t count = readSome(file.number, text.data() + got, room - got);
      if (count < 0) throw InputError(name + ": error: cannot read: " + std::strerror(errno));
      if (count == 0) {
        // Ctrl-C ends the writer of a pipe too, and what it has written is no scene to complain about.
        if (!isKnown || !S_ISREG(status.st_mode)) throwIfInterrupted();
        text.resize(got);
        return text;
      }
      got += size_t(count);
    }
  }
}

void refusePipe(const std::string& path) {
  if (isStream(path)) throw InputError(nameOfInput(path) + ": error: is not a regular file");
}

void refusePipes() {
  pipesAreRefused = true;
}

std::string readRegularFile(const std::string& path) {
  refusePipe(path);
  return readTextFile(path);
}

std::string lowerExtension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
  return extension;
}

std::string sha256Hex(std::string_view bytes) {
  sha256_ctx context;
  sha256_init(&context);
  sha256_update(&context, bytes.size(), reinterpret_cast<const uint8_t*>(bytes.data()));
  std::array<uint8_t, SHA256_DIGEST_SIZE> digest;
  sha256_digest(&context, digest.size(), digest.data());
  std::string hex(BASE16_ENCODE_LENGTH(digest.size()), '\0');
  base16_encode_update(hex.data(), digest.size(), digest.data());
  return hex;
}

}  // namespace turner
