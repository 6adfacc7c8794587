// Figures as JSON, with the keys of the contract (docs/command_line.md).
#pragma once

#include "base/json_writer.h"
#include "image/compare.h"
#include "image/settings.h"

namespace turner {

// Puts them into the object that is open.
void putFigures(JsonWriter& json, const Comparison& comparison);

// An object of counts by kind of ray.
void putCounts(JsonWriter& json, const char* key, const RayCounts& counts);

}  // namespace turner
