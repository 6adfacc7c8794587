// Reads JSON text, comments allowed, into a tree whose values know their places. The text of a file comes in, nodes in
// the order of the text go out; what they mean is for others to say. RapidJSON appears in json_tree.cpp only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"

namespace turner {

enum class JsonKind : uint8_t { null, boolean, number, string, array, object, key };

// An array is followed by its elements, an object by its members: each a key, followed by its value.
struct JsonNode {
  JsonKind kind = JsonKind::null;
  size_t offset = 0;      // of its first byte in the text
  std::string_view text;  // of a string or key what it says, of a number, boolean or null what is written
  size_t next = 0;        // the node behind this one and all that it contains
};

struct JsonTree {
  std::vector<JsonNode> nodes;      // the root comes first
  std::deque<std::string> decoded;  // strings that are not in the text as they are, because of escapes
};

// Containers within containers; a scene has 5 levels. Bounds what readers of the tree must be ready for.
inline constexpr size_t kMaxJsonNesting = 32;

// `text` must outlive the tree. Wrong syntax is one fault, at its place; the tree then is empty. Numbers are kept as
// written: whether a value fits is for the reader of the tree to say.
JsonTree parseJson(std::string_view text, Diagnostics& faults);

}  // namespace turner
