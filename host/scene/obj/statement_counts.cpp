// Looks at the first letters of each line.
#include "scene/obj/statement_counts.h"

#include <algorithm>

namespace turner::obj {

StatementCounts countStatements(std::string_view text) {
  StatementCounts counts;
  for (size_t at = 0; at + 1 < text.size();) {
    if (text[at] == 'f') {
      ++counts.faces;
    } else if (text[at] == 'v') {
      if (text[at + 1] == 'n') {
        ++counts.normals;
      } else if (text[at + 1] != 't') {
        ++counts.vertices;
      }
    }
    const size_t lineEnd = text.find('\n', at);
    if (lineEnd == std::string_view::npos) break;
    at = lineEnd + 1;
  }
  // A file of lines that are cut off must not take more memory than a right one of its size.
  const size_t most = text.size() / std::string_view("v 0 0 0\n").size();
  return {std::min(counts.vertices, most), std::min(counts.normals, most), std::min(counts.faces, most)};
}

}  // namespace turner::obj
