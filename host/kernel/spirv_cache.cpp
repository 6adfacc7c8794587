// A file is: a line that names its format, its key, the two counts, the file numbers, the words, and the SHA-256 in hex
// of all of that. Its name is its key's, so that a file under another's name is recognised by its content.
#include "kernel/spirv_cache.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "base/cache_folder.h"
#include "base/text_file.h"

namespace turner {
namespace {

constexpr std::string_view kFormat = "turner SPIR-V cache 1\n";
constexpr std::string_view kSuffix = ".spirv";
constexpr size_t kHashSize = 64;         // of SHA-256 in hex
using Counts = std::array<uint32_t, 2>;  // of files and words

std::string pathOf(const std::string& folder, const std::string& key) {
  return folder + '/' + key + std::string(kSuffix);
}

// --- contents -------------------------------------------------------------------------------------------------------

std::string_view bytesOf(const uint32_t* values, size_t count) {
  return {reinterpret_cast<const char*>(values), count * sizeof(uint32_t)};
}

std::string encode(const std::string& key, const CachedSpirv& spirv) {
  const Counts counts = {uint32_t(spirv.files.size()), uint32_t(spirv.words.size())};
  std::string bytes(kFormat);
  bytes += key;
  bytes += bytesOf(counts.data(), counts.size());
  bytes += bytesOf(spirv.files.data(), spirv.files.size());
  bytes += bytesOf(spirv.words.data(), spirv.words.size());
  return bytes + sha256Hex(bytes);
}

std::vector<uint32_t> takeValues(std::string_view& bytes, size_t count) {
  std::vector<uint32_t> values(count);
  if (count > 0) std::memcpy(values.data(), bytes.data(), count * sizeof(uint32_t));
  bytes.remove_prefix(count * sizeof(uint32_t));
  return values;
}

std::optional<CachedSpirv> decode(const std::string& key, std::string_view bytes) {
  Counts counts;
  const size_t head = kFormat.size() + key.size() + sizeof counts;
  if (bytes.size() < head + kHashSize) return std::nullopt;
  if (!bytes.starts_with(kFormat) || bytes.substr(kFormat.size(), key.size()) != key) return std::nullopt;
  const std::string_view checksum = bytes.substr(bytes.size() - kHashSize);
  bytes.remove_suffix(kHashSize);
  if (sha256Hex(bytes) != checksum) return std::nullopt;

  std::memcpy(counts.data(), bytes.data() + head - sizeof counts, sizeof counts);
  bytes.remove_prefix(head);
  if (bytes.size() != (uint64_t(counts[0]) + counts[1]) * sizeof(uint32_t)) return std::nullopt;
  CachedSpirv spirv;
  spirv.files = takeValues(bytes, counts[0]);
  spirv.words = takeValues(bytes, counts[1]);
  return spirv;
}

}  // namespace

// --- the cache ------------------------------------------------------------------------------------------------------

std::string spirvKey(std::string_view compiler, const std::vector<ShaderSource>& sources) {
  // Lengths stand before the texts: else two lists of texts could read the same.
  std::string all(kFormat);
  const auto add = [&](std::string_view text) { (all += std::to_string(text.size()) += ' ') += text; };
  add(compiler);
  for (const ShaderSource& source : sources) {
    add(source.name);
    if (source.text)
      add(*source.text);
    else
      all += "unreadable ";
  }
  return sha256Hex(all);
}

std::optional<CachedSpirv> findCached(const std::string& folder, const std::string& key) {
  if (folder.empty()) return std::nullopt;
  const std::optional<std::string> bytes = readCached(pathOf(folder, key));
  return bytes ? decode(key, *bytes) : std::nullopt;
}

void keepCached(const std::string& folder, const std::string& key, const CachedSpirv& spirv) {
  if (folder.empty()) return;
  keepInCache(pathOf(folder, key), kSuffix, encode(key, spirv), kMostCached);
}

}  // namespace turner
