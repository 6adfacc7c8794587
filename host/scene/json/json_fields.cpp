// One reader for each shape of value: it checks, notes the fault at its place, and goes on with a default.
#include "scene/json/json_fields.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/number.h"

namespace turner {

namespace {

// Text from outside, made fit for a line of a message.
std::string cutToPrintable(std::string_view text) {
  constexpr size_t kMost = 60;
  std::string cut(text.substr(0, kMost));
  for (char& c : cut) c = static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  return text.size() > kMost ? cut + "..." : cut;
}

}  // namespace

std::string Field::spell() const {
  std::string text = container ? container->spell() : std::string();
  if (index != kNoIndex) return text + '[' + std::to_string(index) + ']';
  if (!text.empty() && !key.empty()) text += '.';
  return text + cutToPrintable(key);
}

std::string quote(std::string_view text) {
  return '"' + cutToPrintable(text) + '"';
}

std::string suggestName(std::string_view misspelt, const std::vector<std::string>& known, const std::string& allowed) {
  if (const std::string near = nearestName(misspelt, known); !near.empty())
    return "; did you mean " + quote(near) + "?";
  constexpr size_t kMost = 12;
  std::string list;
  for (size_t i = 0; i < std::min(known.size(), kMost); ++i) list += (i ? ", " : "") + quote(known[i]);
  return "; " + allowed + ' ' + list + (known.size() > kMost ? ", ..." : "");
}

std::string JsonFields::describe(size_t at) const {
  const JsonNode& found = node(at);
  switch (found.kind) {
    case JsonKind::string:
    case JsonKind::key:
      return quote(found.text);
    case JsonKind::array:
      return "an array of " + std::to_string(countElements(at));
    case JsonKind::object:
      return "an object";
    default:
      return cutToPrintable(found.text);
  }
}

size_t JsonFields::countElements(size_t at) const {
  size_t count = 0;
  for (size_t i = at + 1; i < node(at).next; i = node(i).next) ++count;
  return count;
}

size_t JsonFields::lineOf(size_t offset) const {
  return 1 + static_cast<size_t>(std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(offset), '\n'));
}

void JsonFields::addMessage(size_t at, const Field& field, const std::string& message) {
  const std::string name = field.spell();
  faults_.add(node(at).offset, name.empty() ? message : name + ": " + message);
}

std::string JsonFields::placeOf(size_t at) const {
  return faults_.placeOf(node(at).offset);
}

void JsonFields::addFault(size_t at, const Field& field, const std::string& allowed) {
  addMessage(at, field, "found " + describe(at) + "; must be " + allowed);
}

void JsonFields::addRepeatedKey(size_t key, size_t first, const Field& field) {
  addMessage(key, field,
             "key " + quote(node(key).text) + " stands twice; it first stands on line " +
                 std::to_string(lineOf(node(first).offset)));
}

void JsonFields::addUnknownKey(size_t key, const Field& field, std::initializer_list<Key> known) {
  std::vector<std::string> names;
  for (const Key& one : known) names.emplace_back(one.name);
  addMessage(key, field, "unknown key " + quote(node(key).text) + suggestName(node(key).text, names, "allowed are"));
}

bool JsonFields::readObject(size_t at, const Field& field, std::initializer_list<Key> keys) {
  if (node(at).kind != JsonKind::object) {
    addFault(at, field, "an object {...}");
    return false;
  }
  std::vector<size_t> places(keys.size(), 0);  // of the keys found; 0 is the root, which is no key
  for (size_t key = at + 1; key < node(at).next; key = node(key).next) {
    const auto known =
        std::find_if(keys.begin(), keys.end(), [&](const Key& one) { return one.name == node(key).text; });
    if (known == keys.end()) {
      addUnknownKey(key, field, keys);
      continue;
    }
    size_t& place = places[static_cast<size_t>(known - keys.begin())];
    if (place != 0) {
      addRepeatedKey(key, place, field);
      continue;
    }
    place = key;
    known->read(key + 1, Field{&field, known->name});
  }
  for (const Key& key : keys) {
    if (key.isRequired && places[static_cast<size_t>(&key - keys.begin())] == 0)
      addMessage(at, field, "key " + quote(key.name) + " is missing; it has no default");
  }
  return true;
}

bool JsonFields::readMembers(size_t at, const Field& field,
                             const std::function<void(std::string_view, size_t, const Field&)>& read) {
  if (node(at).kind != JsonKind::object) {
    addFault(at, field, "an object {...}");
    return false;
  }
  std::unordered_map<std::string_view, size_t> places;
  for (size_t key = at + 1; key < node(at).next; key = node(key).next) {
    const std::string_view name = node(key).text;
    if (const auto [first, isNew] = places.emplace(name, key); isNew) {
      read(name, key + 1, Field{&field, name});
    } else {
      addRepeatedKey(key, first->second, field);
    }
  }
  return true;
}

bool JsonFields::readArray(size_t at, const Field& field, const std::function<void(size_t, const Field&)>& read) {
  if (node(at).kind != JsonKind::array) {
    addFault(at, field, "an array [...]");
    return false;
  }
  size_t index = 0;
  for (size_t i = at + 1; i < node(at).next; i = node(i).next) read(i, Field{&field, {}, index++});
  return true;
}

bool JsonFields::readNumber(size_t at, const Field& field, const NumberRule& rule, double& value) {
  double found = 0;
  const NumberFault fault =
      node(at).kind == JsonKind::number ? parseNumber(node(at).text, found) : NumberFault::notANumber;
  if (fault == NumberFault::tooLarge) {
    addMessage(at, field, "found " + describe(at) + ", which is too large; must be " + rule.allowed);
  } else if (fault != NumberFault::none || !rule.holds(found)) {
    addFault(at, field, rule.allowed);
  } else {
    value = found;
    return true;
  }
  return false;
}

bool JsonFields::readInteger(size_t at, const Field& field, int least, int most, int& value) {
  double found = 0;
  // 5.0 is an integer too, as it is in JSON Schema.
  const bool isInteger = node(at).kind == JsonKind::number && parseNumber(node(at).text, found) == NumberFault::none &&
                         found == std::floor(found);
  if (!isInteger || found < least || found > most) {
    addFault(at, field, "an integer from " + std::to_string(least) + " to " + std::to_string(most));
    return false;
  }
  value = static_cast<int>(found);
  return true;
}

bool JsonFields::readVector(size_t at, const Field& field, const NumberRule& rule, glm::dvec3& value) {
  if (node(at).kind != JsonKind::array || countElements(at) != 3) {
    addFault(at, field, std::string("three numbers [x, y, z], each ") + rule.allowed);
    return false;
  }
  glm::dvec3 found{};
  bool isGood = true;
  readArray(at, field, [&](size_t element, const Field& elementField) {
    isGood &= readNumber(element, elementField, rule, found[static_cast<int>(elementField.index)]);
  });
  if (isGood) value = found;
  return isGood;
}

bool JsonFields::readVectors(size_t at, const Field& field, const NumberRule& rule, std::array<glm::dvec3, 3>& value) {
  if (node(at).kind != JsonKind::array || countElements(at) != 3) {
    addFault(at, field, "three vectors [[x, y, z], [x, y, z], [x, y, z]]");
    return false;
  }
  bool isGood = true;
  readArray(at, field, [&](size_t element, const Field& elementField) {
    isGood &= readVector(element, elementField, rule, value[elementField.index]);
  });
  return isGood;
}

bool JsonFields::readString(size_t at, const Field& field, const char* allowed, std::string& value) {
  if (node(at).kind != JsonKind::string) {
    addFault(at, field, allowed);
    return false;
  }
  value = node(at).text;
  return true;
}

}  // namespace turner
