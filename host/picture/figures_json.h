// Figures as JSON, with the keys of the contract (docs/command_line.md).
#pragma once

#include "json_text.h"
#include "picture/compare.h"
#include "picture/settings.h"

namespace turner {

// Puts them into the object that is open.
void putFigures(JsonText& json, const Comparison& comparison);

// An object of counts by kind of ray.
void putCounts(JsonText& json, const char* key, const RayCounts& counts);

}  // namespace turner
