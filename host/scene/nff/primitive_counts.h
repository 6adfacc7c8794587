// How many primitives an NFF file seems to hold, so that memory for them can be reserved at once.
#pragma once

#include <cstddef>
#include <string_view>

namespace turner::nff {

struct PrimitiveCounts {
  size_t spheres = 0, cones = 0;
  size_t triangles = 0;                   // of polygons
  size_t corners = 0, smoothCorners = 0;  // of polygons, smooth ones too; of these only
};

// Right if each entity begins at the start of its line; never more than a text of this size can hold.
PrimitiveCounts countPrimitives(std::string_view text);

}  // namespace turner::nff
