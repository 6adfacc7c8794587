// Looks at the first letter of each line, and at the number of a polygon's corners.
#include "scene/nff/primitive_counts.h"

#include <algorithm>

namespace turner::nff {

PrimitiveCounts countPrimitives(std::string_view text) {
  PrimitiveCounts counts;
  // The least text that a corner and a sphere may have; a file that announces more must not get the memory for it.
  const size_t mostCorners = text.size() / std::string_view("0 0 0\n").size();
  const size_t mostSpheres = text.size() / std::string_view("s 0 0 0 1\n").size();
  const size_t mostCones = text.size() / std::string_view("c\n0 0 0 1\n0 0 1 1\n").size();
  for (size_t at = 0; at < text.size();) {
    if (text[at] == 's') {
      ++counts.spheres;
    } else if (text[at] == 'c') {
      ++counts.cones;
    } else if (text[at] == 'p') {
      const bool smooth = at + 1 < text.size() && text[at + 1] == 'p';
      size_t corners = 0;
      for (size_t digit = at + (smooth ? 3 : 2); digit < text.size() && corners <= mostCorners; ++digit) {
        if (text[digit] < '0' || text[digit] > '9') break;
        corners = 10 * corners + size_t(text[digit] - '0');
      }
      corners = std::min(corners, mostCorners);
      counts.corners += corners;
      if (smooth) counts.smoothCorners += corners;
      if (corners > 2) counts.triangles += corners - 2;
    }
    const size_t lineEnd = text.find('\n', at);
    if (lineEnd == std::string_view::npos) break;
    at = lineEnd + 1;
  }
  return {.spheres = std::min(counts.spheres, mostSpheres),
          .cones = std::min(counts.cones, mostCones),
          .triangles = std::min(counts.triangles, mostCorners),
          .corners = std::min(counts.corners, mostCorners),
          .smoothCorners = std::min(counts.smoothCorners, mostCorners)};
}

}  // namespace turner::nff
