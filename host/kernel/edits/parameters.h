// Parameters of the shaders: PARAM(float, softness, 0.2) in any source declares a global constant whose value the host
// gives, anew for each picture and without a compilation. Also with a range and a text:
//   PARAM(float, softness, 0.2, 0.0, 1.0, "how wide the light is")
// Types: bool, int, uint, float, vec2, vec3, vec4.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/json_writer.h"
#include "base/parameter_setting.h"
#include "kernel/shader_sources.h"

namespace turner {

enum class ParameterType { boolean, integer, natural, real };

struct Parameter {
  std::string name;
  ParameterType type = ParameterType::real;
  int components = 1;
  std::array<double, 4> value{};      // the default, until it is set
  std::optional<double> least, most;  // of each component
  std::string text;
  SourceLocation location;

  bool operator==(const Parameter& other) const { return name == other.name && value == other.value; }

  // Without its place.
  template <class Bytes>
  void fields(Bytes& b) {
    b(name, type, components, value, least, most, text);
  }
};

// Sources in which each PARAM is replaced by what the compiler knows; lines stay.
struct ParameterisedSources {
  std::vector<ShaderSource> sources;
  std::vector<Parameter> parameters;
};

// Throws InputError with a line for each declaration that is wrong.
ParameterisedSources readParameters(const std::vector<ShaderSource>& sources);

// Sets values by name, the later ones last. Throws InputError with a line for each setting of an unknown name, of
// another type, or out of range; the parameters are then as before.
void setParameters(std::vector<Parameter>& parameters, std::span<const ParameterSetting> settings);

// "softness=0.3", as --set takes it: numbers with commas between, true or false. Throws InputError if it is no such
// thing.
ParameterSetting parseSetting(const std::string& text, const std::string& place);

// Words for the kernel, one for each in the order of their declarations (Frame::parameters of layout.h).
std::vector<std::array<uint32_t, 4>> packParameters(const std::vector<Parameter>& parameters);
// "float", "vec3".
std::string typeName(const Parameter& parameter);
// "0.3", "1,0.5,0", "true": as --set takes it.
std::string valueText(const Parameter& parameter);
// As an object by their names, { "softness": 0.3 }: by itself, and into an object that is open.
std::string parametersJson(const std::vector<Parameter>& parameters);
void putParameters(JsonWriter& json, const char* key, const std::vector<Parameter>& parameters);
// "softness=0.3 tint=1,0.5,0".
std::string valuesText(const std::vector<Parameter>& parameters);

}  // namespace turner
