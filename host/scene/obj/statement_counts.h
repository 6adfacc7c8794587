// How many statements an OBJ file seems to hold, so that memory for them can be reserved at once.
#pragma once

#include <cstddef>
#include <string_view>

namespace turner::obj {

struct StatementCounts {
  size_t vertices = 0, normals = 0, faces = 0;
};

// At least, since lines may be indented and faces may have more than three corners; never more than a text of this size
// can hold.
StatementCounts countStatements(std::string_view text);

}  // namespace turner::obj
