// System calls and nettle.
#include "base/text_file.h"

#include <nettle/base16.h>
#include <nettle/sha2.h>
#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include "base/descriptor_io.h"
#include "base/errors.h"
#include "base/reserve.h"
#include "base/unique_fd.h"

namespace turner {

std::string readTextFile(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw InputError(path + ": error: is a folder, not a file");
  const UniqueFd file(openToRead(path));
  if (file.number < 0) throw InputError(path + ": error: cannot open: " + std::strerror(errno));

  // One byte more than the size, so that one more read tells the end. A pipe has no size, and a file may grow.
  struct stat status {};
  size_t room = fstat(file.number, &status) == 0 ? size_t(status.st_size) + 1 : 1;
  std::string text;
  for (size_t got = 0;; room = 2 * room + (size_t(1) << 16)) {
    text.reserve(room);
    prefault(text.data() + got, room - got);
    text.resize(room);
    while (got < room) {
      const ssize_t count = readSome(file.number, text.data() + got, room - got);
      if (count < 0) throw InputError(path + ": error: cannot read: " + std::strerror(errno));
      if (count == 0) {
        text.resize(got);
        return text;
      }
      got += size_t(count);
    }
  }
}

void refusePipe(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
      !std::filesystem::is_directory(status))
    throw InputError(path + ": error: is not a regular file");
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
