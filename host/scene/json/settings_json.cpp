// The values are what JSON has; parameters.h says what a shader takes.
#include "scene/json/settings_json.h"

#include <utility>

#include "scene/json/json_tree.h"

namespace turner {
namespace {

void readSetting(JsonFields& fields, std::string_view name, size_t at, const Field& field,
                 std::vector<ParameterSetting>& settings) {
  ParameterSetting setting{std::string(name), {}, false, fields.placeOf(at) + field.spell()};
  const auto readNumber = [&](size_t place, const Field& which) {
    double value = 0;
    if (fields.readNumber(place, which, kAnyNumber, value)) setting.values.push_back(value);
  };
  switch (fields.node(at).kind) {
    case JsonKind::boolean:
      setting.isBoolean = true;
      setting.values = {fields.node(at).text == "true" ? 1.0 : 0.0};
      break;
    case JsonKind::array:
      fields.readArray(at, field, readNumber);
      break;
    case JsonKind::number:
      readNumber(at, field);
      break;
    default:
      fields.addFault(at, field, "a number, an array of numbers, true or false");
  }
  settings.push_back(std::move(setting));
}

}  // namespace

void readSettings(JsonFields& fields, size_t at, const Field& field, std::vector<ParameterSetting>& settings) {
  fields.readMembers(at, field, [&](std::string_view name, size_t place, const Field& member) {
    readSetting(fields, name, place, member, settings);
  });
}

std::vector<ParameterSetting> parseSettings(const std::string& path, std::string_view text) {
  Diagnostics faults(path, text);
  const JsonTree tree = parseJson(text, faults);
  faults.throwIfAny();
  JsonFields fields(tree, text, faults);
  std::vector<ParameterSetting> settings;
  readSettings(fields, 0, {}, settings);
  faults.throwIfAny();
  return settings;
}

}  // namespace turner
