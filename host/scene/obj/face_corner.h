// The corners of a face as words: v, v/vt, v//vn, v/vt/vn. In a header since there are as many as a mesh has, three
// times over: they are read inline.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/number.h"

namespace turner::obj {

inline constexpr uint32_t kNoIndex = UINT32_MAX;

// Indices from 0.
struct FaceCorner {
  uint32_t vertex = 0;
  uint32_t normal = kNoIndex;
};

// An index as the file gives it, from 1 or from the end, as an index from 0; kNoIndex if there is none such.
inline uint32_t resolveIndex(std::string_view text, size_t count) {
  long long index = 0;
  const auto known = (long long)count;
  if (parseInteger(text, index) != NumberFault::none || index == 0 || index < -known || index > known) return kNoIndex;
  return uint32_t(index > 0 ? index - 1 : known + index);
}

// Reads a corner without signs whose indices exist, as almost all are. False for any other.
inline bool readPlainCorner(std::string_view text, size_t vertices, size_t normals, FaceCorner& corner) {
  const char* at = text.data();
  const char* const end = at + text.size();
  // An index of a few digits; 0 if there is none.
  const auto readIndex = [&] {
    constexpr std::ptrdiff_t kMostDigits = 9;
    const char* const last = at + std::min(kMostDigits, end - at);
    uint32_t index = 0;
    for (; at != last && *at >= '0' && *at <= '9'; ++at) index = 10 * index + uint32_t(*at - '0');
    return index;
  };
  const uint32_t vertex = readIndex();
  if (vertex == 0 || vertex > vertices) return false;
  corner = {vertex - 1, kNoIndex};
  if (at == end) return true;
  if (*at++ != '/') return false;
  readIndex();  // the texture coordinate is not used
  if (at == end) return true;
  if (*at++ != '/') return false;
  if (at == end) return true;
  const uint32_t normal = readIndex();
  if (at != end || normal == 0 || normal > normals) return false;
  corner.normal = normal - 1;
  return true;
}

}  // namespace turner::obj
