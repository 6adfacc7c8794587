// The figures of a comparison as JSON, with the keys of the contract (docs/command_line.md).
#pragma once

#include "json_text.h"
#include "picture/compare.h"

namespace turner {

// Puts them into the object that is open.
void putFigures(JsonText& json, const Comparison& comparison);

}  // namespace turner
