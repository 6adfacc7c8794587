// Settings of parameters as JSON, { "softness": 0.3, "tint": [1, 0.5, 0], "on": true }: of a scene, or by themselves.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/parameter_setting.h"
#include "scene/json/json_fields.h"

namespace turner {

// Whether the shaders have such parameters is seen when they are compiled.
void readSettings(JsonFields& fields, size_t at, const Field& field, std::vector<ParameterSetting>& settings);

// A text that is nothing but such an object. Throws InputError with all its faults, placed in `path`.
std::vector<ParameterSetting> parseSettings(const std::string& path, std::string_view text);

}  // namespace turner
