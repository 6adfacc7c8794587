// Reads declarations by their tokens, so that comments and directives do not count.
#include "kernel/edits/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include "base/diagnostics.h"
#include "base/errors.h"
#include "base/number.h"
#include "kernel/glsl_tokens.h"
#include "kernel/source_names.h"
#include "layout.h"

namespace turner {
namespace {

struct TypeWord {
  const char* word;
  ParameterType type;
  int components;
};
constexpr TypeWord kTypes[] = {
    {"bool", ParameterType::boolean, 1}, {"int", ParameterType::integer, 1}, {"uint", ParameterType::natural, 1},
    {"float", ParameterType::real, 1},   {"vec2", ParameterType::real, 2},   {"vec3", ParameterType::real, 3},
    {"vec4", ParameterType::real, 4},
};

constexpr char kForm[] =
    "write PARAM(float, name, 0.2) or PARAM(float, name, 0.2, 0.0, 1.0, \"what it is\"), with bool, int, uint, float, "
    "vec2, vec3 or vec4";

std::string joined(const Parameter& parameter, std::string_view between) {
  std::string text;
  for (int i = 0; i < parameter.components; ++i) {
    const double value = parameter.value[size_t(i)];
    if (i > 0) text += between;
    // A float in the fewest digits that tell it.
    text += parameter.type == ParameterType::boolean ? (value != 0 ? "true" : "false")
            : parameter.type == ParameterType::real  ? fmt::format("{}", float(value))
                                                     : fmt::format("{:.0f}", value);
  }
  return text;
}

// What is wrong with a value; empty if it fits.
std::string faultOf(const Parameter& parameter, double value) {
  const auto out = [&](const std::string& allowed) { return fmt::format("found {:.9g}; must be {}", value, allowed); };
  const bool isWhole = std::floor(value) == value;
  if (parameter.type == ParameterType::integer && !(isWhole && value >= -2147483648.0 && value <= 2147483647.0))
    return out("a whole number from -2147483648 to 2147483647");
  if (parameter.type == ParameterType::natural && !(isWhole && value >= 0 && value <= 4294967295.0))
    return out("a whole number from 0 to 4294967295");
  if (parameter.type == ParameterType::real && !(std::abs(value) <= double(std::numeric_limits<float>::max())))
    return out("a number that float32 can hold");
  if (parameter.least && (value < *parameter.least || value > *parameter.most))
    return out(fmt::format("from {:g} to {:g}", *parameter.least, *parameter.most));
  return "";
}

// --- declarations ----------------------------------------------------------------------------------------------------

// Of one source.
class Declarations {
 public:
  Declarations(const ShaderSource& source, std::vector<Parameter>& parameters, std::string& faults)
      : source_(source), tokens_(readGlslTokens(*source.text)), parameters_(parameters), faults_(faults) {}

  // The text with all declarations replaced.
  std::string replaced() {
    const std::string& text = *source_.text;
    std::string result;
    size_t done = 0;
    for (at_ = 0; at_ + 1 < tokens_.size(); ++at_) {
      if (!is("PARAM") || tokens_[at_ + 1].text != "(") continue;
      const size_t begin = tokens_[at_].offset;
      const std::optional<Parameter> parameter = read();
      const size_t end = tokens_[std::min(at_, tokens_.size() - 1)].offset + 1;
      result += text.substr(done, begin - done);
      if (parameter) result += declarationOf(*parameter, parameters_.size());
      // Lines stay where they are.
      for (const char c : std::string_view(text).substr(begin, end - begin))
        if (c == '\n' || c == '\r') result += c;
      const bool hasSemicolon = at_ + 1 < tokens_.size() && tokens_[at_ + 1].text == ";";
      if (parameter && !hasSemicolon) result += ';';
      done = end;
      if (parameter) parameters_.push_back(*parameter);
    }
    return result + text.substr(done);
  }

 private:
  static std::string declarationOf(const Parameter& parameter, size_t index) {
    static constexpr char kComponents[] = "xyzw";
    std::string components(kComponents, size_t(parameter.components));
    const std::string words = fmt::format("frameInMemory.parameters[{}].{}", index, components);
    const std::string value = parameter.type == ParameterType::real      ? "uintBitsToFloat(" + words + ")"
                              : parameter.type == ParameterType::boolean ? words + " != 0u"
                              : parameter.type == ParameterType::integer ? "int(" + words + ")"
                                                                         : words;
    return fmt::format("{} {} = {}", typeName(parameter), parameter.name, value);
  }

  bool is(std::string_view text) const { return at_ < tokens_.size() && tokens_[at_].text == text; }

  void fault(size_t token, const std::string& message) {
    const size_t offset = tokens_[std::min(token, tokens_.size() - 1)].offset;
    faults_ += (faults_.empty() ? "" : "\n") + faultAt(locationAt(source_, offset)) + message;
  }

  // Numbers with a sign, as many as stand there: 0.2, -1, 2u, 1.0f.
  bool readNumber(double& value) {
    const bool negative = is("-");
    if (negative || is("+")) ++at_;
    if (at_ >= tokens_.size()) return false;
    std::string digits(tokens_[at_].text);
    const bool isHex = digits.starts_with("0x") || digits.starts_with("0X");
    const std::string_view suffixes = isHex ? "uU" : "uUfF";
    while (!digits.empty() && suffixes.find(digits.back()) != std::string_view::npos) digits.pop_back();
    if (isHex) {
      uint32_t word = 0;
      const char* const end = digits.data() + digits.size();
      if (std::from_chars(digits.data() + 2, end, word, 16) != std::from_chars_result{end, std::errc()}) return false;
      value = word;
    } else if (parseNumber(digits, value) != NumberFault::none) {
      return false;
    }
    if (negative) value = -value;
    ++at_;
    return true;
  }

  bool readDefault(Parameter& parameter) {
    if (parameter.type == ParameterType::boolean) {
      if (!is("true") && !is("false")) return false;
      parameter.value[0] = is("true");
      ++at_;
      return true;
    }
    if (parameter.components == 1) return readNumber(parameter.value[0]);
    if (!is(typeName(parameter))) return false;
    ++at_;
    if (!is("(")) return false;
    int count = 0;
    do {
      ++at_;
      if (count == parameter.components || !readNumber(parameter.value[size_t(count)])) return false;
      ++count;
    } while (is(","));
    if (!is(")")) return false;
    ++at_;
    // vec3(1) is vec3(1, 1, 1).
    if (count == 1) std::fill_n(parameter.value.begin(), parameter.components, parameter.value[0]);
    return count == 1 || count == parameter.components;
  }

  // From PARAM on; at_ stands at the closing bracket afterwards.
  std::optional<Parameter> read() {
    const size_t begin = at_;
    Parameter parameter;
    parameter.location = locationAt(source_, tokens_[begin].offset);
    const std::string wrong = readParts(parameter);
    if (wrong.empty()) return parameter;
    fault(begin, wrong);
    // On behind the bracket.
    at_ = begin + 1;
    for (int depth = 0; at_ < tokens_.size(); ++at_) {
      if (is("(")) ++depth;
      if (is(")") && --depth == 0) break;
    }
    return std::nullopt;
  }

  // What is wrong; empty: nothing.
  std::string readParts(Parameter& parameter) {
    const std::string form = std::string("this is no parameter; ") + kForm;
    at_ += 2;
    const auto type = std::find_if(std::begin(kTypes), std::end(kTypes), [&](const TypeWord& t) { return is(t.word); });
    if (type == std::end(kTypes)) return form;
    parameter.type = type->type;
    parameter.components = type->components;
    ++at_;
    if (!is(",")) return form;
    ++at_;
    if (at_ >= tokens_.size() || tokens_[at_].kind != GlslKind::word) return form;
    parameter.name = tokens_[at_].text;
    ++at_;
    if (!is(",")) return form;
    ++at_;
    if (!readDefault(parameter))
      return fmt::format("{}: the default must be {}; {}", parameter.name,
                         parameter.type == ParameterType::boolean ? "true or false"
                         : parameter.components == 1              ? "a number"
                                                                  : typeName(parameter) + "(...) of numbers",
                         kForm);
    if (is(",") && at_ + 1 < tokens_.size() && tokens_[at_ + 1].kind != GlslKind::string) {
      double least = 0, most = 0;
      ++at_;
      if (!readNumber(least) || !is(",")) return form;
      ++at_;
      if (!readNumber(most)) return form;
      if (least > most)
        return fmt::format("{}: the range is from {:g} to {:g}; the lesser comes first", parameter.name, least, most);
      parameter.least = least;
      parameter.most = most;
    }
    if (is(",")) {
      ++at_;
      if (at_ >= tokens_.size() || tokens_[at_].kind != GlslKind::string) return form;
      parameter.text = tokens_[at_].text.substr(1, tokens_[at_].text.size() - 2);
      ++at_;
    }
    if (!is(")")) return form;
    for (int i = 0; i < parameter.components; ++i)
      if (const std::string wrong = faultOf(parameter, parameter.value[size_t(i)]); !wrong.empty())
        return parameter.name + ": the default: " + wrong;
    for (const Parameter& other : parameters_)
      if (other.name == parameter.name)
        return fmt::format("{} is declared already, in {}:{}; take another name", parameter.name, other.location.path,
                           other.location.line);
    if (parameters_.size() == gpu::kMostParameters)
      return fmt::format("{}: there are {} parameters already, as many as there is room for", parameter.name,
                         gpu::kMostParameters);
    return "";
  }

  const ShaderSource& source_;
  const std::vector<GlslToken> tokens_;
  std::vector<Parameter>& parameters_;
  std::string& faults_;
  size_t at_ = 0;
};

// --- settings --------------------------------------------------------------------------------------------------------

std::string describe(const ParameterSetting& setting) {
  if (setting.isBoolean) return setting.values[0] != 0 ? "true" : "false";
  return setting.values.size() == 1 ? "a number" : fmt::format("{} numbers", setting.values.size());
}

// What is wrong with a setting; empty: it was set.
std::string set(Parameter& parameter, const ParameterSetting& setting) {
  const bool wantsBoolean = parameter.type == ParameterType::boolean;
  if (setting.isBoolean != wantsBoolean || int(setting.values.size()) != parameter.components)
    return fmt::format("found {}; {} is a {}: must be {}", describe(setting), parameter.name, typeName(parameter),
                       wantsBoolean                ? "true or false"
                       : parameter.components == 1 ? "a number"
                                                   : fmt::format("{} numbers", parameter.components));
  for (const double value : setting.values)
    if (std::string wrong = faultOf(parameter, value); !wrong.empty()) return wrong;
  std::copy(setting.values.begin(), setting.values.end(), parameter.value.begin());
  return "";
}

std::string unknownName(const std::vector<Parameter>& parameters, const std::string& name) {
  if (parameters.empty())
    return "the shaders have no parameters; one is declared by PARAM(float, " + name + ", 0.2) in an edited source";
  std::vector<std::string> known;
  for (const Parameter& parameter : parameters) known.push_back(parameter.name);
  const std::string nearest = nearestName(name, known);
  std::string text = "the shaders have no parameter of this name";
  if (!nearest.empty()) return text + "; did you mean " + nearest + "?";
  text += "; there are ";
  for (size_t i = 0; i < known.size(); ++i) text += (i == 0 ? "" : ", ") + known[i];
  return text;
}

}  // namespace

ParameterisedSources readParameters(const std::vector<ShaderSource>& sources) {
  ParameterisedSources result{sources, {}};
  std::string faults;
  for (ShaderSource& source : result.sources)
    if (source.text && source.text->find("PARAM") != std::string::npos)
      source.text = Declarations(ShaderSource(source), result.parameters, faults).replaced();
  if (!faults.empty()) throw InputError(faults);
  return result;
}

void setParameters(std::vector<Parameter>& parameters, std::span<const ParameterSetting> settings) {
  std::vector<Parameter> changed = parameters;
  std::string faults;
  for (const ParameterSetting& setting : settings) {
    const auto found = std::find_if(changed.begin(), changed.end(),
                                    [&](const Parameter& parameter) { return parameter.name == setting.name; });
    const std::string fault = found == changed.end() ? unknownName(changed, setting.name) : set(*found, setting);
    if (!fault.empty()) faults += (faults.empty() ? "" : "\n") + setting.place + ": " + fault;
  }
  if (!faults.empty()) throw InputError(faults);
  parameters = std::move(changed);
}

ParameterSetting parseSetting(const std::string& text, const std::string& place) {
  const size_t equals = text.find('=');
  const auto refuse = [&] {
    throw InputError(place + ": found '" + text +
                     "'; must be NAME=VALUE, such as softness=0.3, tint=1,0.5,0 or on=true");
  };
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) refuse();
  ParameterSetting setting{text.substr(0, equals), {}, false, place + ' ' + text};
  const std::string value = text.substr(equals + 1);
  if (value == "true" || value == "false") {
    setting.isBoolean = true;
    setting.values = {value == "true" ? 1.0 : 0.0};
    return setting;
  }
  for (size_t at = 0; at <= value.size();) {
    const size_t end = std::min(value.find(',', at), value.size());
    double number = 0;
    if (parseNumber(std::string_view(value).substr(at, end - at), number) != NumberFault::none) refuse();
    setting.values.push_back(number);
    at = end + 1;
  }
  return setting;
}

std::vector<std::array<uint32_t, 4>> packParameters(const std::vector<Parameter>& parameters) {
  std::vector<std::array<uint32_t, 4>> words;
  for (const Parameter& parameter : parameters) {
    std::array<uint32_t, 4> word{};
    for (int i = 0; i < parameter.components; ++i) {
      const double value = parameter.value[size_t(i)];
      word[size_t(i)] = parameter.type == ParameterType::real      ? std::bit_cast<uint32_t>(float(value))
                        : parameter.type == ParameterType::integer ? uint32_t(int32_t(value))
                                                                   : uint32_t(value);
    }
    words.push_back(word);
  }
  return words;
}

std::string typeName(const Parameter& parameter) {
  for (const TypeWord& type : kTypes)
    if (type.type == parameter.type && type.components == parameter.components) return type.word;
  return "";
}

std::string valueText(const Parameter& parameter) {
  return joined(parameter, ",");
}

namespace {

void putAll(JsonWriter& json, const std::vector<Parameter>& parameters) {
  for (const Parameter& parameter : parameters) {
    const char* const name = parameter.name.c_str();
    if (parameter.type == ParameterType::boolean)
      json.put(name, parameter.value[0] != 0);
    else if (parameter.type != ParameterType::real)
      json.put(name, int64_t(parameter.value[0]));
    else if (parameter.components == 1)
      json.put(name, parameter.value[0]);
    else
      json.array(name, [&] {
        for (int i = 0; i < parameter.components; ++i) json.put(parameter.value[size_t(i)]);
      });
  }
}

}  // namespace

std::string parametersJson(const std::vector<Parameter>& parameters) {
  JsonWriter json;
  json.object([&] { putAll(json, parameters); });
  return json.text();
}

void putParameters(JsonWriter& json, const char* key, const std::vector<Parameter>& parameters) {
  json.object(key, [&] { putAll(json, parameters); });
}

std::string valuesText(const std::vector<Parameter>& parameters) {
  std::string text;
  for (const Parameter& parameter : parameters)
    text += (text.empty() ? "" : " ") + parameter.name + '=' + valueText(parameter);
  return text;
}

}  // namespace turner
