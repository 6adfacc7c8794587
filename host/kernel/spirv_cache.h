// Keeps compiled shaders between runs of the program, each under a key of all that it depends on. Whatever is wrong
// with the folder or a file in it, the cache is then just empty: nothing here is an error or changes a result.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernel/shader_sources.h"

namespace turner {

struct CachedSpirv {
  std::vector<uint32_t> words;
  std::vector<uint32_t> files;  // which of the key's sources the compiler read, in its order
};

// Most files that the cache holds; the ones not used for longest go.
constexpr size_t kMostCached = 64;

// SHA-256 in hex of the sources' names and texts, of which compiler reads them with which options, and of the format
// of the cache's files. Where the shader's folder is does not matter.
std::string spirvKey(std::string_view compiler, const std::vector<ShaderSource>& sources);

// What was kept under a key, if it is there and undamaged.
std::optional<CachedSpirv> findCached(const std::string& folder, const std::string& key);

// Keeps a shader if it can: makes the folder and the one above it, and drops what has not been used for longest.
// Readers and writers in other processes see a whole file or none.
void keepCached(const std::string& folder, const std::string& key, const CachedSpirv& spirv);

}  // namespace turner
