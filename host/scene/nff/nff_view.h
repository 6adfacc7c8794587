// The view of an NFF file: the entity `v` and its lines.
#pragma once

#include <string_view>

#include "scene/nff/nff_lines.h"
#include "scene/scene_load.h"

namespace turner::nff {

// Whether a word begins a line of a view, as "from".
bool isViewWord(std::string_view word);

// Reads the lines below `v`, which is `word`, in any order, into the camera and the size of the picture. Goes to the
// line behind them; false at the end of the file.
bool parseView(Lines& lines, const Token& word, ParsedScene& parsed);

}  // namespace turner::nff
